#include "deepslam/layouts/matrix_camera.h"

#include <utility>

#include "deepslam/dataset/capture_settings.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/settle_images.h"

namespace deepslam::layouts {

Result<MatrixCamera> ReadMatrixCamera(const std::filesystem::path& file,
                                      const std::filesystem::path& folder,
                                      const std::vector<dataset::ImagePair>& pairs) {
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const auto m = formats::ParseNumbers(*text, file, 9, "a 3 x 3 matrix");
  if (!m) return m.error();
  const Result<dataset::ImageSize> size = FirstColourSize(folder, pairs);
  if (!size) return size.error();
  const PinholeCamera camera{size->width, size->height, (*m)[0], (*m)[4], (*m)[2], (*m)[5]};
  if (const Status plausible = dataset::CheckCamera(camera, file); !plausible)
    return plausible.error();
  return MatrixCamera{camera, *std::move(text)};
}

}  // namespace deepslam::layouts
