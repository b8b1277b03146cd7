#include "deepslam/formats/sens_file.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <type_traits>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"

namespace deepslam::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kFrameHeadBytes = 16 * 4 + 4 * 8;  // pose, two times, two sizes
// Of the sensor; a longer one means that this is no .sens file.
constexpr std::uint64_t kMaxSensorNameBytes = 4096;
constexpr std::uint32_t kMaxSidePx = 16384;  // a header of more is refused before memory is taken
// 1 GiB, of one compressed image; a claim of more is refused.
constexpr std::uint64_t kMaxImageBytes = std::uint64_t{1} << 30;

// Bytes from the front of a file, with what is left of it known.
class Input {
 public:
  Input(std::ifstream& in, std::uint64_t size) : in_(in), size_(size) {}

  [[nodiscard]] std::uint64_t at() const { return at_; }
  [[nodiscard]] std::uint64_t left() const { return size_ - at_; }

  template <typename T>
  bool Take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return Take(reinterpret_cast<char*>(&value), sizeof(T));
  }
  bool Take(char* to, std::size_t count) {
    if (count > left()) return false;
    in_.read(to, static_cast<std::streamsize>(count));
    at_ += count;
    return static_cast<bool>(in_);
  }
  bool Skip(std::uint64_t count) {
    if (count > left()) return false;
    at_ += count;
    in_.seekg(static_cast<std::streamoff>(at_));
    return static_cast<bool>(in_);
  }

 private:
  std::ifstream& in_;
  std::uint64_t size_;
  std::uint64_t at_ = 0;
};

Error FileError(const fs::path& file, std::string_view fault) {
  return InvalidInput(fmt::format("{}: {}", file.string(), fault));
}

Status CheckHeader(const fs::path& file, const SensHeader& header, std::uint64_t bytes_left) {
  if (header.colour_codec < SensColourCodec::kRaw || header.colour_codec > SensColourCodec::kJpeg) {
    return FileError(file,
                     fmt::format("field 'colour codec' is {}; read are 0 (raw), 1 (PNG), 2 (JPEG)",
                                 static_cast<int>(header.colour_codec)));
  }
  if (header.depth_codec < SensDepthCodec::kRaw || header.depth_codec > SensDepthCodec::kOcci) {
    return FileError(
        file,
        fmt::format("field 'depth codec' is {}; read are 0 (raw), 1 (zlib), 2 (Occipital)",
                    static_cast<int>(header.depth_codec)));
  }
  for (const auto& [name, size] : {std::pair("colour width", header.colour_width),
                                   {"colour height", header.colour_height},
                                   {"depth width", header.depth_width},
                                   {"depth height", header.depth_height}}) {
    if (size < 1 || size > kMaxSidePx)
      return FileError(file,
                       fmt::format("field '{}' is {}, outside 1 .. {}", name, size, kMaxSidePx));
  }
  if (!(header.depth_shift >= 1 && header.depth_shift <= 1e6)) {
    return FileError(file,
                     fmt::format("field 'depth shift' is {}, outside 1 .. 1000000 (usual: 1000)",
                                 header.depth_shift));
  }
  if (header.num_frames > bytes_left / kFrameHeadBytes) {
    return FileError(file,
                     fmt::format("field 'number of frames' is {}, the {} bytes after it hold {} at "
                                 "most: is the file whole?",
                                 header.num_frames,
                                 bytes_left,
                                 bytes_left / kFrameHeadBytes));
  }
  return Ok();
}

Status ReadHeader(const fs::path& file, Input& input, SensHeader& header) {
  const auto ends = [&] { return FileError(file, "ends within its header (truncated?)"); };
  if (!input.Take(header.version)) return ends();
  if (header.version != 3 && header.version != 4) {
    return FileError(file,
                     fmt::format("field 'version' is {}; versions 3 and 4 of .sens files are read",
                                 header.version));
  }
  std::uint64_t length = 0;
  if (!input.Take(length)) return ends();
  if (length > std::min(kMaxSensorNameBytes, input.left())) {
    return FileError(
        file, fmt::format("field 'length of the sensor's name' is {}: no .sens file?", length));
  }
  header.sensor_name.resize(length);
  if (!input.Take(header.sensor_name.data(), length)) return ends();
  for (std::array<float, 16>* matrix : {&header.colour_intrinsics,
                                        &header.colour_extrinsics,
                                        &header.depth_intrinsics,
                                        &header.depth_extrinsics}) {
    if (!input.Take(*matrix)) return ends();
  }
  if (!input.Take(header.colour_codec) || !input.Take(header.depth_codec)) return ends();
  for (std::uint32_t* size :
       {&header.colour_width, &header.colour_height, &header.depth_width, &header.depth_height}) {
    if (!input.Take(*size)) return ends();
  }
  if (!input.Take(header.depth_shift) || !input.Take(header.num_frames)) return ends();
  return CheckHeader(file, header, input.left());
}

// False at the end of the file, or where a size reaches past it.
bool ReadFrame(Input& input, SensFrame& frame) {
  if (!input.Take(frame.world_from_depth) || !input.Take(frame.colour_time_us) ||
      !input.Take(frame.depth_time_us) || !input.Take(frame.colour_bytes) ||
      !input.Take(frame.depth_bytes)) {
    return false;
  }
  frame.colour_offset = input.at();
  if (!input.Skip(frame.colour_bytes)) return false;
  frame.depth_offset = input.at();
  return input.Skip(frame.depth_bytes);
}

template <typename T>
void Append(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

Result<SensIndex> ReadSensIndex(const fs::path& file) {
  std::error_code code;
  const std::uintmax_t size = fs::file_size(file, code);
  if (code) return FileError(file, fmt::format("cannot be read ({})", code.message()));
  std::ifstream in(file, std::ios::binary);
  if (!in) return FileError(file, "cannot be read; check its permissions");
  Input input(in, size);
  SensIndex index;
  if (Status status = ReadHeader(file, input, index.header); !status) return status.error();
  for (std::uint64_t i = 0; i < index.header.num_frames; ++i) {
    SensFrame frame;
    if (!ReadFrame(input, frame)) break;
    index.frames.push_back(frame);
  }
  if (index.frames.empty()) {
    return FileError(file,
                     index.header.num_frames == 0
                         ? "holds no frames"
                         : "ends within its first frame (truncated, or a size in it is wrong)");
  }
  if (index.header.version >= 4 && index.frames.size() == index.header.num_frames &&
      !input.Take(index.num_motions)) {
    index.num_motions = 0;
  }
  return index;
}

Result<std::string> ReadRange(const fs::path& file, std::uint64_t offset, std::uint64_t num_bytes) {
  if (num_bytes > kMaxImageBytes)
    return FileError(file, fmt::format("an image of {} bytes is too large", num_bytes));
  return dataset::ReadFilePiece(file, offset, num_bytes);
}

std::string EncodeSensHeader(const SensHeader& header) {
  std::string bytes;
  Append(bytes, header.version);
  Append(bytes, static_cast<std::uint64_t>(header.sensor_name.size()));
  bytes += header.sensor_name;
  Append(bytes, header.colour_intrinsics);
  Append(bytes, header.colour_extrinsics);
  Append(bytes, header.depth_intrinsics);
  Append(bytes, header.depth_extrinsics);
  Append(bytes, header.colour_codec);
  Append(bytes, header.depth_codec);
  Append(bytes, header.colour_width);
  Append(bytes, header.colour_height);
  Append(bytes, header.depth_width);
  Append(bytes, header.depth_height);
  Append(bytes, header.depth_shift);
  Append(bytes, header.num_frames);
  return bytes;
}

std::string EncodeSensFrame(const SensFrame& frame) {
  std::string bytes;
  Append(bytes, frame.world_from_depth);
  Append(bytes, frame.colour_time_us);
  Append(bytes, frame.depth_time_us);
  Append(bytes, frame.colour_bytes);
  Append(bytes, frame.depth_bytes);
  return bytes;
}

}  // namespace deepslam::formats
