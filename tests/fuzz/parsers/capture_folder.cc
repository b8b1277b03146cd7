// A whole capture folder of any layout, as a text: lines "=== NAME" begin files; a file whose text
// is "@colour" or "@depth" is an image of 8 x 6 px.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "deepslam/dataset/image_files.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/layouts/open_capture.h"
#include "fuzz/entry.h"

namespace deepslam::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 8;
constexpr int kHeight = 6;
constexpr int kMaxFiles = 16;

const std::string& Image(bool depth) {
  static const std::string colour =
      *image_codec::EncodePng(ColourImage(kWidth, kHeight, Rgb8{9, 8, 7}));
  static const std::string raw =
      *image_codec::EncodePng(dataset::RawDepthImage(kWidth, kHeight, 1500));
  return depth ? raw : colour;
}

bool IsPlain(const fs::path& name) {
  if (name.empty() || name.is_absolute() || name.native().size() > 80 ||
      name.native().find('\0') != std::string::npos)
    return false;
  for (const fs::path& part : name) {
    if (part == ".." || part == "." || part.empty()) return false;
  }
  return true;
}

// In memory where that is possible.
class Folder {
 public:
  Folder() {
    const bool in_memory = fs::is_directory("/dev/shm");
    std::string pattern =
        (in_memory ? fs::path("/dev/shm") : fs::temp_directory_path()) / "deepslam-fuzz-XXXXXX";
    DEEPSLAM_CHECK(::mkdtemp(pattern.data()) != nullptr, "a folder can be made");
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace
}  // namespace deepslam::fuzz

DEEPSLAM_FUZZ(capture_folder) {
  const Folder folder;
  constexpr std::string_view kBegin = "=== ";
  std::size_t at = bytes.find(kBegin);
  for (int n = 0; at != std::string_view::npos && n < kMaxFiles; ++n) {
    const std::size_t line = std::min(bytes.find('\n', at), bytes.size());
    const fs::path name(bytes.substr(at + kBegin.size(), line - at - kBegin.size()));
    const std::size_t begin = std::min(line + 1, bytes.size());
    const std::size_t next = bytes.find("\n=== ", line);
    std::string_view text =
        bytes.substr(begin, next == std::string_view::npos ? next : next + 1 - begin);
    at = next == std::string_view::npos ? next : next + 1;
    if (!IsPlain(name)) continue;
    if (text.starts_with("@colour")) text = Image(false);
    if (text.starts_with("@depth")) text = Image(true);
    std::error_code ignored;
    fs::create_directories((folder.path() / name).parent_path(), ignored);
    std::ofstream(folder.path() / name, std::ios::binary) << text;
  }
  const auto capture = layouts::OpenCapture(folder.path());
  if (!capture.ok()) return Refused(capture.error(), folder.path().string());
  for (std::size_t i = 0; i < 2 && i < static_cast<std::size_t>(capture->frames->num_frames()); ++i)
    (void)capture->frames->Read(FrameIdx{static_cast<int>(i)});
  return true;
}
