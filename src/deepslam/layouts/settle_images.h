// What the image files themselves say of a capture's cameras: depth that is coarser than colour,
// depth as real numbers, colour that lies on its side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/layouts/layout.h"

namespace deepslam::layouts {

// The view of a camera in images of another size. kInvalidInput where the shape is another (by more
// than 2 %), naming both sizes and what to do; `file` is one of those images.
[[nodiscard]] Result<PinholeCamera> SameView(const PinholeCamera& camera,
                                             const dataset::ImageSize& size,
                                             const std::filesystem::path& file);

// Of the first colour file that can be read; an error of the first where none can.
[[nodiscard]] Result<dataset::ImageSize> FirstColourSize(
    const std::filesystem::path& folder, const std::vector<dataset::ImagePair>& pairs);
// Of the first depth file likewise.
[[nodiscard]] Result<dataset::DepthFileKind> FirstDepthKind(
    const std::filesystem::path& folder, const std::vector<dataset::ImagePair>& pairs);

struct SettledImages {
  dataset::CaptureCameras cameras;
  dataset::ImageForm form;
};

// Whether depth that is coarser than colour is what every capture of a layout has (phones), or
// worth a warning.
enum class CoarserDepth { kSaid, kUsual };

// The layout's cameras (depth_units_per_m 0: it does not know) with what capture.yaml states
// (WithStated) and what the files are: depth of colour's place and of another size is taken for
// colour's view, real numbers for metres unless depth_units_per_m is stated. Refuses images of
// another shape and whole numbers of unknown units.
[[nodiscard]] Result<SettledImages> SettleImages(const LayoutSource& source,
                                                 const dataset::CaptureCameras& of_layout,
                                                 const std::vector<dataset::ImagePair>& pairs,
                                                 std::vector<std::string>& warnings,
                                                 CoarserDepth coarser = CoarserDepth::kSaid);

}  // namespace deepslam::layouts
