// Views and models of objects out of what stages wrote, for the module `modelling`.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/modelling/frame_views.h"
#include "deepslam/modelling/model_source.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/observe/object_views.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/overrides.h"
#include "deepslam/stages/config.h"

namespace deepslam::stages {

// Cut out of the frames by the segments of stage `associate`, whose masks lie in a scratch file.
// Frames and classes outlive the views.
[[nodiscard]] Result<modelling::FrameViews> OpenViews(const pipeline::StageContext& context,
                                                      const FrameSource& frames,
                                                      const ClassTable& classes,
                                                      const observe::ViewOptions& options);

// models/<key>.binvox of the stage before `loops` that made it. The context outlives it.
class StageModels final : public modelling::ModelSource {
 public:
  explicit StageModels(const pipeline::StageContext& context) : context_(context) {}
  [[nodiscard]] Result<VoxelGrid> Read(CandidateSource source,
                                       const std::string& key) const override;

 private:
  const pipeline::StageContext& context_;
};

// The corrections outlive the options.
[[nodiscard]] modelling::ObjectOptions ObjectOptionsOf(const Config& config,
                                                       const Overrides& corrections);

}  // namespace deepslam::stages
