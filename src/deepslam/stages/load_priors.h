// The shape networks of a folder.
#pragma once

#include <filesystem>
#include <memory>

#include "deepslam/core/result.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// Of every class of the table that has a folder CLASS/ with sketch.onnx, encoder.onnx and
// decoder.onnx. InvalidInput naming the file when one is missing or is no such network, and when
// there is none at all.
[[nodiscard]] Result<propose::ShapePriors> LoadPriors(const std::filesystem::path& folder,
                                                      const ClassTable& classes);

// Those that the run's options name, or those that are found; shared by the stages of a run and the
// runs of a process where inputs.models is there. Null where there are none.
[[nodiscard]] Result<std::shared_ptr<const propose::ShapePriors>> PriorsOf(const RunInputs& inputs);

}  // namespace deepslam::stages
