// What stages `export` and `report` read of the others.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/presentation/compact_map.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/presentation/report_page.h"
#include "deepslam/scene/measured_parts.h"

namespace deepslam::stages {

[[nodiscard]] presentation::RunIdentity IdentityOf(const dataset::Capture& capture);

struct ExportInputs {
  presentation::FinishedMap finished;
  presentation::ShapeCodes codes;
  // Between which keyframes tracking and the loops measured something.
  std::vector<KeyframeJoin> joins;
  std::vector<std::string> doubts;  // of the detections
};

[[nodiscard]] Result<ExportInputs> ReadExportInputs(const pipeline::StageContext& context);

// A mesh or a room that is not there is empty: the page shows the rest. `run` and
// `capture_warnings` are left to the caller.
[[nodiscard]] Result<presentation::ReportSources> ReadReportSources(
    const pipeline::StageContext& context);

}  // namespace deepslam::stages
