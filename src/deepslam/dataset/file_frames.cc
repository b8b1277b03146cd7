#include "deepslam/dataset/file_frames.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "deepslam/core/every_nth.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/dataset/read_faults.h"

namespace deepslam::dataset {
namespace {

namespace fs = std::filesystem;

// Digests of so many take 0.5 MB, whatever the capture's length.
constexpr std::size_t kPairsHashedAtOnce = 4096;

// Of the contents of colour and depth of each pair, in turn.
Result<std::vector<std::string>> Digests(const fs::path& folder, std::span<const ImagePair> pairs) {
  std::vector<std::string> digests(2 * pairs.size());
  ReadFaults faults;
  ParallelFor(digests.size(), [&](std::size_t i) {
    const ImagePair& pair = pairs[i / 2];
    const Result<std::string> bytes =
        ReadFileBytes(folder / (i % 2 == 0 ? pair.colour : pair.depth).file);
    if (!bytes) faults.Note(bytes.error());
    digests[i] = bytes ? Sha256Hex(*bytes) : "unreadable";
  });
  if (std::optional<Error> fault = faults.first()) return *std::move(fault);
  return digests;
}

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// SUN3D's PNG files hold depth turned by three bits.
void TurnBitsBack(RawDepthImage& depth) {
  for (std::uint16_t& raw : depth)
    raw = static_cast<std::uint16_t>(raw >> 3U | static_cast<std::uint32_t>(raw) << 13U);
}

class FileFrames final : public StoredFrames {
 public:
  // Colour files are the frames' names.
  FileFrames(fs::path folder,
             const CaptureCameras& cameras,
             std::vector<StoredFrame> frames,
             std::vector<std::string> depth_files,
             ImageForm form)
      : StoredFrames(cameras, std::move(frames)),
        folder_(std::move(folder)),
        depth_files_(std::move(depth_files)),
        form_(std::move(form)) {}

  [[nodiscard]] Result<StoredColour> ReadColour(std::size_t i) const override {
    if (form_.video != nullptr) return ReadVideoFrame(i);
    const fs::path file = folder_ / frames()[i].colour_name;
    Result<std::string> bytes = ReadFileBytes(file);
    if (!bytes) return bytes.error();
    StoredColour colour{CodecOf(*bytes), *std::move(bytes), ColourImage(), file.string()};
    if (colour.codec != ImageCodec::kOther) return colour;
    const PinholeCamera& camera = cameras().colour;
    Result<ColourImage> pixels = DecodeColour(colour.bytes, file, camera.width, camera.height);
    if (!pixels) return pixels.error();
    colour.pixels = *std::move(pixels);
    colour.bytes.clear();
    return colour;
  }

  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    const PinholeCamera& camera = cameras().depth;
    Result<RawDepthImage> depth =
        ReadDepthFile(folder_ / depth_files_[i], camera.width, camera.height, form_.raw_per_real);
    if (depth && form_.rotated_bits) TurnBitsBack(*depth);
    const bool all_sure =
        form_.confidence.empty() || form_.confidence[i].empty() || form_.min_confidence <= 0;
    if (!depth || all_sure) return depth;
    const Result<Image<std::uint8_t>> confidence =
        ReadGreyFile(folder_ / form_.confidence[i], camera.width, camera.height);
    if (!confidence) return confidence.error();
    std::transform(depth->begin(),
                   depth->end(),
                   confidence->begin(),
                   depth->begin(),
                   [&](std::uint16_t raw, std::uint8_t sure) {
                     return sure < form_.min_confidence ? kNoDepth : raw;
                   });
    return depth;
  }

  [[nodiscard]] bool colour_in_order() const override { return form_.video != nullptr; }

  [[nodiscard]] std::shared_ptr<const StoredFrames> Every(std::size_t step) const override {
    ImageForm form = form_;
    form.confidence = EveryNth(form_.confidence, step);
    form.video_frames = EveryNth(form_.video_frames, step);
    return std::make_shared<FileFrames>(folder_,
                                        cameras(),
                                        EveryNth(frames(), step),
                                        EveryNth(depth_files_, step),
                                        std::move(form));
  }

 private:
  [[nodiscard]] Result<StoredColour> ReadVideoFrame(std::size_t i) const {
    StoredColour colour;
    colour.name = fmt::format("{}, frame {}", form_.video->file().string(), form_.video_frames[i]);
    Result<ColourImage> pixels = form_.video->Read(form_.video_frames[i]);
    if (!pixels) return pixels.error();
    colour.pixels = *std::move(pixels);
    return colour;
  }

  fs::path folder_;
  std::vector<std::string> depth_files_;
  ImageForm form_;
};

}  // namespace

Result<ColourImage> DecodeStored(StoredColour stored, const PinholeCamera& camera) {
  if (stored.codec == ImageCodec::kOther) return std::move(stored.pixels);
  return DecodeColour(stored.bytes, stored.name, camera.width, camera.height);
}

std::unique_ptr<const StoredFrames> MakeFileFrames(
    const fs::path& folder,
    const CaptureCameras& cameras,
    std::vector<ImagePair> pairs,
    const std::vector<std::optional<Pose3>>& world_from_colour,
    ImageForm form) {
  DEEPSLAM_CHECK(world_from_colour.size() == pairs.size(), "one pose entry per frame");
  DEEPSLAM_CHECK(form.confidence.empty() || form.confidence.size() == pairs.size(),
                 "one confidence file per frame");
  DEEPSLAM_CHECK(form.video == nullptr || form.video_frames.size() == pairs.size(),
                 "one frame of the video per frame");
  std::vector<StoredFrame> frames;
  std::vector<std::string> depth_files;
  frames.reserve(pairs.size());
  depth_files.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    frames.push_back({pairs[i].colour.time_s,
                      pairs[i].depth.time_s,
                      std::move(pairs[i].colour.file),
                      world_from_colour[i]});
    depth_files.push_back(std::move(pairs[i].depth.file));
  }
  return std::make_unique<FileFrames>(
      folder, cameras, std::move(frames), std::move(depth_files), std::move(form));
}

Status CheckFilesExist(const fs::path& folder,
                       const std::vector<ImagePair>& pairs,
                       std::vector<std::string>& warnings) {
  std::size_t num_missing = 0;
  const TimedFile* first = nullptr;
  for (const ImagePair& pair : pairs) {
    const bool colour_there = IsFile(folder / pair.colour.file);
    if (colour_there && IsFile(folder / pair.depth.file)) continue;
    ++num_missing;
    if (first == nullptr) first = colour_there ? &pair.depth : &pair.colour;
  }
  if (num_missing == 0) return Ok();
  const std::string place =
      first->line > 0 ? fmt::format(" (line {} of its list)", first->line) : std::string();
  const std::string what = fmt::format("{}: file is missing{}; {} of {} frames lack an image",
                                       (folder / first->file).string(),
                                       place,
                                       num_missing,
                                       pairs.size());
  if (2 * num_missing > pairs.size())
    return InvalidInput(what + ": is the capture unpacked completely?");
  warnings.push_back(what + " and will be skipped");
  return Ok();
}

Result<std::string> HashFiles(std::string_view tag,
                              std::span<const NamedText> texts,
                              const fs::path& folder,
                              const std::vector<ImagePair>& pairs) {
  Sha256 hash;
  hash.Update(fmt::format("{} 1\n", tag));
  for (const NamedText& text : texts) {
    hash.Update(fmt::format("{} {}\n", text.name, text.digest));
  }
  for (std::size_t begin = 0; begin < pairs.size(); begin += kPairsHashedAtOnce) {
    const auto some =
        std::span(pairs).subspan(begin, std::min(kPairsHashedAtOnce, pairs.size() - begin));
    const Result<std::vector<std::string>> digests = Digests(folder, some);
    if (!digests) return digests.error();
    for (std::size_t i = 0; i < some.size(); ++i) {
      hash.Update(fmt::format("{} {} {}\n{} {} {}\n",
                              some[i].colour.time_s,
                              some[i].colour.file,
                              (*digests)[2 * i],
                              some[i].depth.time_s,
                              some[i].depth.file,
                              (*digests)[2 * i + 1]));
    }
  }
  return hash.HexDigest();
}

Result<std::string> HashLargeFile(const fs::path& file) {
  constexpr std::uintmax_t kPieceBytes = std::uintmax_t{1} << 22;
  std::error_code code;
  const std::uintmax_t size = fs::file_size(file, code);
  if (code)
    return InvalidInput(fmt::format("{}: cannot be read ({})", file.string(), code.message()));
  Sha256 hash;
  for (std::uintmax_t at = 0; at < size; at += kPieceBytes) {
    const Result<std::string> piece = ReadFilePiece(file, at, std::min(kPieceBytes, size - at));
    if (!piece) return piece.error();
    hash.Update(*piece);
  }
  return hash.HexDigest();
}

Result<std::optional<std::string>> ReadOptional(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(fs::symlink_status(file, ignored))) return std::optional<std::string>();
  Result<std::string> text = ReadTextFile(file);
  if (!text) return text.error();
  return std::optional<std::string>(*std::move(text));
}

std::vector<std::string> ListFiles(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    std::error_code ignored;
    std::string name = entry->path().filename().string();
    if (!name.starts_with('.') && entry->is_regular_file(ignored)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace deepslam::dataset
