// Everything that the report page of a run shows, out of what its stages made.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/run_verdict.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::presentation {

// A frame that the detector looked at.
struct DetectedFrame {
  FrameIdx frame;
  std::optional<bool> contains_person;  // nothing where no network looked
};

// What the stages made.
struct ReportSources {
  RunIdentity run;
  std::vector<std::string> capture_warnings;
  Trajectory trajectory;  // as tracked
  Ground ground;          // of the tracked path
  std::vector<DetectedFrame> detected;
  std::vector<Segment> segments;  // without masks
  Association association;        // with its rejections
  Proposals proposals;            // all candidates; models are not needed
  Loops loops;
  FinishedMap finished;
  RunVerdict verdict;
  std::vector<std::string> corrections;  // of a person, one sentence each
  std::string scene_glb;                 // empty = no 3D view
};

// Where the page gets what is too large to be held.
struct ReportAccess {
  const FrameSource& frames;
  // These segments with their masks.
  std::function<Result<std::vector<Segment>>(const std::set<DetectionId>&)> segments_of;
  // A candidate's shape; null where it cannot be had. Asked by several threads at once.
  std::function<std::shared_ptr<const shape::ShapeModel>(const ShapeCandidate&, bool chosen)>
      model_of;
};

struct ReportPage {
  report::ReportContent content;  // but stage_summaries, file_bytes and sizes of files
  report::Picture thumbnail;      // of the map, for lists; no bytes: there is nothing to see
};

// Frames with a person in them are shown nowhere; where no detector looked for people, the page
// says so. Errors: those of `segments_of`; Interrupted().
[[nodiscard]] Result<ReportPage> MakeReportPage(const ReportSources& sources,
                                                const ReportAccess& access,
                                                const ClassTable& classes,
                                                const Progress& progress);

}  // namespace deepslam::presentation
