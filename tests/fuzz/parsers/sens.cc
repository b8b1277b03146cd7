// ScanNet's .sens files: the index, then the images of the first frames.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "deepslam/dataset/image_files.h"
#include "deepslam/formats/sens_codecs.h"
#include "deepslam/formats/sens_file.h"
#include "fuzz/entry.h"

namespace deepslam::fuzz {
namespace {

constexpr std::size_t kFramesRead = 2;

// A file in memory under a path of its own.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : handle_(::memfd_create("fuzz.sens", 0)) {
    DEEPSLAM_CHECK(handle_ >= 0, "memory files are there");
    const auto written = ::write(handle_, bytes.data(), bytes.size());
    DEEPSLAM_CHECK(written == static_cast<ssize_t>(bytes.size()), "memory files take bytes");
  }
  ~MemoryFile() { ::close(handle_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::filesystem::path path() const {
    return "/proc/self/fd/" + std::to_string(handle_);
  }

 private:
  int handle_;
};

}  // namespace
}  // namespace deepslam::fuzz

DEEPSLAM_FUZZ(sens) {
  const MemoryFile file(bytes);
  const Result<formats::SensIndex> index = formats::ReadSensIndex(file.path());
  if (!index.ok()) return Refused(index.error(), file.path().string());
  const formats::SensHeader& header = index->header;
  for (std::size_t i = 0; i < std::min(index->frames.size(), kFramesRead); ++i) {
    const formats::SensFrame& frame = index->frames[i];
    DEEPSLAM_CHECK(frame.depth_offset + frame.depth_bytes <= bytes.size(),
                   "frames lie in the file");
    const auto colour = formats::ReadRange(file.path(), frame.colour_offset, frame.colour_bytes);
    const auto depth = formats::ReadRange(file.path(), frame.depth_offset, frame.depth_bytes);
    DEEPSLAM_CHECK(colour.ok() && depth.ok(), "frames of the index can be read");
    if (header.colour_codec != formats::SensColourCodec::kRaw) {
      (void)dataset::DecodeColour(*colour,
                                  kFile,
                                  static_cast<int>(header.colour_width),
                                  static_cast<int>(header.colour_height));
    }
    (void)formats::UnpackDepth(header.depth_codec,
                               *depth,
                               static_cast<int>(header.depth_width),
                               static_cast<int>(header.depth_height));
  }
  return true;
}
