// OpenEXR, one channel of it: Z, else depth, Y, R, or the only one there is. Half and 32-bit
// numbers, converted by the library.
#include <algorithm>
#include <cstring>
#include <exception>
#include <string>

#include <fmt/format.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIO.h>

#include "deepslam/image_codec/depth_formats.h"

namespace deepslam::image_codec {
namespace {

// The most that Deflate makes of a byte; OpenEXR's other packings make less.
constexpr std::size_t kMaxExpansion = 1032;

class Bytes final : public Imf::IStream {
 public:
  explicit Bytes(std::string_view bytes) : IStream("image"), bytes_(bytes) {}

  bool read(char* to, int count) override {
    if (count < 0 || at_ > bytes_.size() || static_cast<std::size_t>(count) > bytes_.size() - at_)
      throw std::runtime_error("file ends too early");
    std::memcpy(to, bytes_.data() + at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::uint64_t>(count);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }
  void clear() override {}

 private:
  std::string_view bytes_;
  std::uint64_t at_ = 0;
};

Error EndsTooEarly() { return InvalidInput("OpenEXR header ends too early (truncated?)"); }

// Four bytes, the lowest first; there must be as many.
std::uint32_t NumberAt(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t k = 4; k-- > 0;)
    number = number << 8U | static_cast<unsigned char>(bytes[at + k]);
  return number;
}

struct Attribute {
  std::string_view name;
  std::string_view kind;
  std::string_view value;
};

// Whether the lengths inside a value are those of what lies there.
bool HoldsWhatItSays(const Attribute& attribute) {
  std::string_view left = attribute.value;
  if (attribute.kind == "preview") {
    return left.size() >= 8 &&
           std::uint64_t{NumberAt(left, 0)} * NumberAt(left, 4) == (left.size() - 8) / 4;
  }
  if (attribute.kind != "stringvector") return true;
  while (!left.empty()) {
    if (left.size() < 4 || NumberAt(left, 0) > left.size() - 4) return false;
    left.remove_prefix(4 + NumberAt(left, 0));
  }
  return true;
}

Status CheckWindow(std::string_view box, std::size_t num_bytes) {
  if (box.size() != 16) return InvalidInput("OpenEXR header is damaged (dataWindow)");
  const auto side = [&](std::size_t axis) {
    const auto at = [&](std::size_t k) {
      return std::int64_t{static_cast<std::int32_t>(NumberAt(box, k))};
    };
    return at(4 * axis + 8) - at(4 * axis) + 1;
  };
  return CheckDepthSize(side(0), side(1), num_bytes, kMaxExpansion);
}

Result<Attribute> ReadAttribute(std::string_view bytes, std::size_t at) {
  const std::size_t name_end = bytes.find('\0', at);
  if (name_end == std::string_view::npos) return EndsTooEarly();
  const std::size_t kind_end = bytes.find('\0', name_end + 1);
  if (kind_end == std::string_view::npos || bytes.size() - kind_end < 5) return EndsTooEarly();
  const std::size_t size = NumberAt(bytes, kind_end + 1);
  if (size > bytes.size() - kind_end - 5) return EndsTooEarly();
  return Attribute{bytes.substr(at, name_end - at),
                   bytes.substr(name_end + 1, kind_end - name_end - 1),
                   bytes.substr(kind_end + 5, size)};
}

// The library takes whatever memory a header asks for: it is walked through before.
Status CheckHeader(std::string_view bytes) {
  // Bit of the version: names up to 255 bytes, which change nothing else.
  constexpr std::uint32_t kLongNames = 0x400;
  if (bytes.size() < 9) return EndsTooEarly();
  if ((NumberAt(bytes, 4) & ~(0xFFU | kLongNames)) != 0) {
    return InvalidInput(
        "OpenEXR image in tiles, of several parts or deep; written by scan lines it is read");
  }
  std::size_t at = 8;
  while (at < bytes.size() && bytes[at] != '\0') {
    const Result<Attribute> attribute = ReadAttribute(bytes, at);
    if (!attribute) return attribute.error();
    if (!HoldsWhatItSays(*attribute))
      return InvalidInput(fmt::format("OpenEXR header is damaged ({})", attribute->kind));
    if (attribute->name == "dataWindow") {
      const Status sane = CheckWindow(attribute->value, bytes.size());
      if (!sane) return sane;
    }
    at = static_cast<std::size_t>(attribute->value.data() + attribute->value.size() - bytes.data());
  }
  return at < bytes.size() ? Ok() : EndsTooEarly();
}

// Empty where none is depth for sure.
std::string DepthChannel(const Imf::ChannelList& channels) {
  for (const char* name : {"Z", "depth", "Depth", "Y", "R"}) {
    if (channels.findChannel(name) != nullptr) return name;
  }
  if (channels.begin() == channels.end()) return {};
  auto second = channels.begin();
  ++second;
  return second == channels.end() ? channels.begin().name() : std::string();
}

struct Opened {
  DepthStructure structure;
  std::string channel;
};

Result<Opened> Examine(const Imf::Header& header, std::size_t num_bytes) {
  const Imath::Box2i& window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (const Status sane = CheckDepthSize(width, height, num_bytes, kMaxExpansion); !sane)
    return sane.error();
  const std::string channel = DepthChannel(header.channels());
  if (channel.empty())
    return InvalidInput(
        "OpenEXR image of several channels of which none is called Z, depth, Y or R");
  const Imf::Channel& found = header.channels()[channel.c_str()];
  if (found.type == Imf::UINT || found.xSampling != 1 || found.ySampling != 1)
    return InvalidInput(
        fmt::format("OpenEXR channel '{}' is not of real numbers, one a pixel", channel));
  return Opened{{DepthFormat::kExr, static_cast<int>(width), static_cast<int>(height), true},
                channel};
}

Result<DepthPixels> Decode(std::string_view bytes) {
  Bytes stream(bytes);
  Imf::InputFile file(stream, 0);  // threads
  const Result<Opened> opened = Examine(file.header(), bytes.size());
  if (!opened) return opened.error();
  Image<float> image(opened->structure.width, opened->structure.height);
  const Imath::Box2i& window = file.header().dataWindow();
  Imf::FrameBuffer buffer;
  buffer.insert(opened->channel,
                Imf::Slice::Make(Imf::FLOAT,
                                 image.data(),
                                 window,
                                 sizeof(float),
                                 sizeof(float) * static_cast<std::size_t>(image.width())));
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return DepthPixels(std::move(image));
}

Error Damaged(const std::exception& fault) {
  return InvalidInput(fmt::format("OpenEXR image is damaged or ends too early ({})", fault.what()));
}

}  // namespace

Result<DepthStructure> ExrStructure(std::string_view bytes) {
  if (const Status sane = CheckHeader(bytes); !sane) return sane.error();
  try {
    Bytes stream(bytes);
    const Imf::InputFile file(stream, 0);
    const Result<Opened> opened = Examine(file.header(), bytes.size());
    if (!opened) return opened.error();
    return opened->structure;
  } catch (const std::exception& fault) {
    return Damaged(fault);
  }
}

Result<DepthPixels> DecodeExr(std::string_view bytes) {
  if (const Status sane = CheckHeader(bytes); !sane) return sane.error();
  try {
    return Decode(bytes);
  } catch (const std::exception& fault) {
    return Damaged(fault);
  }
}

}  // namespace deepslam::image_codec
