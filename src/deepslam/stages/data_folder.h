// Where weights and the furniture library lie on this machine.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::stages {

// PREFIX/share/deepslam of the running program PREFIX/bin/deepslam: `configs` and `scripts` as in
// the source tree, where it was installed. May not exist; empty when the system does not tell.
[[nodiscard]] std::filesystem::path InstalledFolder();

// `explicit_folder` if not empty, else $DEEPSLAM_DATA, else the installed folder where it holds
// weights or a library, else ${XDG_DATA_HOME:-~/.local/share}/deepslam.
[[nodiscard]] std::filesystem::path FindDataFolder(const std::string& explicit_folder);

// A name ("yolov8s") is DATA/weights/NAME.onnx; anything with a slash or ending in .onnx is a path;
// empty is yolo11n-seg, whose detections have masks, or yolov8s where that alone is there.
// kInvalidInput with what to run when the file is missing.
[[nodiscard]] Result<std::filesystem::path> FindWeights(const std::filesystem::path& data_folder,
                                                        const std::string& weights);

// `library` if not empty, else DATA/library. kInvalidInput with what to run when there is none.
[[nodiscard]] Result<std::filesystem::path> FindLibrary(const std::filesystem::path& data_folder,
                                                        const std::string& library);

// `priors` if not empty, else DATA/priors, else those that came with the program: a folder with a
// folder for each class. Nothing when none is named and none is there; kInvalidInput with what to
// do when the one named is missing.
[[nodiscard]] Result<std::optional<std::filesystem::path>> FindPriors(
    const std::filesystem::path& data_folder, const std::string& priors);

}  // namespace deepslam::stages
