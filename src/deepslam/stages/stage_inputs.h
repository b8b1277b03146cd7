// What several stages read and write alike: typed values out of other stages' files.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/detections_json.h"
#include "deepslam/artifact/summary_json.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/coarse_surface.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// Its edges lie in a scratch file of the stage.
[[nodiscard]] Result<Odometry> ReadOdometry(const pipeline::StageContext& context);
// Without the edges, for what asks for none: of a long capture they are most of it.
[[nodiscard]] Result<Trajectory> ReadTrajectory(const pipeline::StageContext& context);
[[nodiscard]] Result<Ground> ReadGround(const pipeline::StageContext& context,
                                        std::string_view stage);
[[nodiscard]] Result<Layout> ReadLayout(const pipeline::StageContext& context);
[[nodiscard]] Result<CoarseSurface> ReadCoarseSurface(const pipeline::StageContext& context);
[[nodiscard]] Result<artifact::DetectionTable> ReadDetections(
    const pipeline::StageContext& context);
// Of each detection, by stage `segment`; of each member of a track, by `associate`.
[[nodiscard]] Result<std::vector<Segment>> ReadSegments(const pipeline::StageContext& context,
                                                        std::string_view stage);
// Of the members of tracks.
[[nodiscard]] Result<std::vector<Segment>> ReadSegmentsWithoutMasks(
    const pipeline::StageContext& context);
// Those of these detections alone.
[[nodiscard]] Result<std::vector<Segment>> ReadSegmentsOf(const pipeline::StageContext& context,
                                                          const std::set<DetectionId>& wanted);
// Of stage `associate`, or of `loops` after merging.
[[nodiscard]] Result<Association> ReadAssociation(const pipeline::StageContext& context,
                                                  std::string_view stage);
// Without the models. Of stage `propose`; or with what stage `select` made of them, and `loops` of
// merged objects where that is `last_stage`.
[[nodiscard]] Result<Proposals> ReadProposals(const pipeline::StageContext& context);
[[nodiscard]] Result<Proposals> ReadCandidates(const pipeline::StageContext& context,
                                               std::string_view last_stage);
// The stage before `loops` that made a model of this source.
[[nodiscard]] std::string_view StageOfModel(CandidateSource source);
[[nodiscard]] Result<VoxelGrid> ReadModel(const pipeline::StageContext& context,
                                          std::string_view stage,
                                          const std::string& key);
[[nodiscard]] Result<std::vector<CandidateRegistration>> ReadRegistrations(
    const pipeline::StageContext& context);
[[nodiscard]] Result<ObjectMap> ReadObjects(const pipeline::StageContext& context,
                                            std::string_view stage);
[[nodiscard]] Result<Loops> ReadLoops(const pipeline::StageContext& context);
[[nodiscard]] Result<OptimizedMap> ReadOptimized(const pipeline::StageContext& context);

// A mesh that stage `mesh` or `fuse` wrote.
[[nodiscard]] Result<TriangleMesh> ReadMesh(const pipeline::StageContext& context,
                                            std::string_view stage,
                                            const std::string& file);

// Writes an encoded text, or passes its error on.
[[nodiscard]] Status WriteEncoded(pipeline::StageContext& context,
                                  std::string_view file,
                                  const Result<std::string>& text);
struct EncodedFile {
  std::string_view name;
  std::function<Result<std::string>()> encode;
};
// One after another, so that no two texts are in memory; the first error ends it.
[[nodiscard]] Status WriteFiles(pipeline::StageContext& context,
                                const std::vector<EncodedFile>& files);
// overrides.json: what the stage applied of a person's corrections (mostly nothing).
[[nodiscard]] Status WriteApplied(pipeline::StageContext& context,
                                  const std::vector<std::string>& applied);
// What a stage (ground, associate or select) applied.
[[nodiscard]] Result<std::vector<std::string>> ReadApplied(const pipeline::StageContext& context,
                                                           std::string_view stage);
// doubts.json of stage `detect`: what makes the run's result doubtful (mostly nothing).
[[nodiscard]] Result<std::vector<std::string>> ReadDoubts(const pipeline::StageContext& context);
// models/<key>.binvox each.
[[nodiscard]] Status WriteModels(pipeline::StageContext& context,
                                 const std::map<std::string, VoxelGrid>& grids);
// The chosen models of a map as models/<key>.binvox, each from the stage that made it; `own` are
// this stage's.
[[nodiscard]] Status CopyChosenModels(pipeline::StageContext& context,
                                      const ObjectMap& map,
                                      const std::map<std::string, VoxelGrid>& own);

// That a workspace of so many frames and with these segments was made of this capture; InvalidInput
// otherwise.
[[nodiscard]] Status CheckOfThisCapture(std::size_t num_frames,
                                        std::span<const Segment> segments,
                                        const FrameSource& frames);

}  // namespace deepslam::stages
