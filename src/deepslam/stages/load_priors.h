// The shape networks of a folder.
#pragma once

#include <filesystem>

#include "deepslam/core/result.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::stages {

// Of every class of the table that has a folder CLASS/ with sketch.onnx, encoder.onnx and
// decoder.onnx. InvalidInput naming the file when one is missing or is no such network, and when
// there is none at all.
[[nodiscard]] Result<propose::ShapePriors> LoadPriors(const std::filesystem::path& folder,
                                                      const ClassTable& classes);

}  // namespace deepslam::stages
