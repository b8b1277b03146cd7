#include "deepslam/stages/object_sources.h"

#include <utility>

#include "deepslam/overrides/choices.h"
#include "deepslam/stages/disk_segment_store.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

Result<modelling::FrameViews> OpenViews(const pipeline::StageContext& context,
                                        const FrameSource& frames,
                                        const ClassTable& classes,
                                        const observe::ViewOptions& options) {
  auto segments = DiskSegmentStore::Read(context);
  if (!segments.ok()) return segments.error();
  return modelling::FrameViews(
      {frames, std::move(segments).value(), classes}, options, context.progress());
}

Result<VoxelGrid> StageModels::Read(CandidateSource source, const std::string& key) const {
  return ReadModel(context_, StageOfModel(source), key);
}

modelling::ObjectOptions ObjectOptionsOf(const Config& config, const Overrides& corrections) {
  return {config.registration,
          config.select,
          config.shape_refinement,
          config.propose_stage.use_depth,
          {corrections.file, [&corrections](ObjectId object, auto candidates) {
             return overrides::ChosenByHand(corrections, object, candidates);
           }}};
}

}  // namespace deepslam::stages
