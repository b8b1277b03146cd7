// RTAB-Map's database: one file NAME.db with colour (JPEG, PNG), depth (PNG of 16 bits in mm, or of
// real numbers), calibration, time and odometry's pose of every node.
#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/every_nth.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/rtabmap_database.h"
#include "deepslam/image_codec/depth_image.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/image_codec/structure.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/settle_images.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres: RTAB-Map's 16-bit depth

// Raw depth in millimetres, however the node has it.
Result<RawDepthImage> DecodeNodeDepth(std::string_view bytes) {
  const image_codec::ImageStructure structure = image_codec::StructureOf(bytes);
  if (structure.format == image_codec::ImageFormat::kPng && structure.channels == 4) {
    const Result<Image<float>> metres = image_codec::DecodePngFloat(bytes);
    if (!metres) return metres.error();
    RawDepthImage raw(metres->width(), metres->height());
    std::transform(metres->begin(), metres->end(), raw.begin(), [](float m) {
      const double units = static_cast<double>(m) * kUnitsPerM;
      return units >= 0.5 && units < kSaturatedDepth - 0.5
                 ? static_cast<std::uint16_t>(std::lround(units))
                 : kNoDepth;
    });
    return raw;
  }
  if (structure.format != image_codec::ImageFormat::kPng)
    return InvalidInput("depth is no PNG image (RVL is not read): export it by rtabmap-export");
  return image_codec::DecodePngGrey16(bytes);
}

class DatabaseFrames final : public dataset::StoredFrames {
 public:
  DatabaseFrames(fs::path file,
                 std::shared_ptr<formats::RtabMapDatabase> database,
                 const dataset::CaptureCameras& cameras,
                 std::vector<dataset::StoredFrame> frames,
                 std::vector<std::int64_t> ids)
      : StoredFrames(cameras, std::move(frames)),
        file_(std::move(file)),
        database_(std::move(database)),
        ids_(std::move(ids)) {}

  [[nodiscard]] Result<dataset::StoredColour> ReadColour(std::size_t i) const override {
    Result<formats::NodeImages> images = database_->Images(ids_[i]);
    if (!images) return images.error();
    dataset::StoredColour colour{
        dataset::CodecOf(images->colour), std::move(images->colour), {}, NameOf(i)};
    if (colour.codec == dataset::ImageCodec::kOther)
      return InvalidInput(colour.name + ": colour is neither a PNG nor a JPEG image");
    return colour;
  }

  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    const Result<formats::NodeImages> images = database_->Images(ids_[i]);
    if (!images) return images.error();
    Result<RawDepthImage> depth = DecodeNodeDepth(images->depth);
    if (!depth) return InvalidInput(NameOf(i) + ": " + depth.error().message);
    const PinholeCamera& camera = cameras().depth;
    if (depth->width() == camera.width && depth->height() == camera.height) return depth;
    return InvalidInput(fmt::format("{}: depth is {} x {} px, the first node's {} x {}",
                                    NameOf(i),
                                    depth->width(),
                                    depth->height(),
                                    camera.width,
                                    camera.height));
  }

  [[nodiscard]] std::shared_ptr<const StoredFrames> Every(std::size_t step) const override {
    return std::make_shared<DatabaseFrames>(
        file_, database_, cameras(), EveryNth(frames(), step), EveryNth(ids_, step));
  }

 private:
  [[nodiscard]] std::string NameOf(std::size_t i) const {
    return fmt::format("{}, node {}", file_.string(), ids_[i]);
  }

  fs::path file_;
  std::shared_ptr<formats::RtabMapDatabase> database_;
  std::vector<std::int64_t> ids_;
};

// The file itself, or the only .db file of a folder.
std::optional<fs::path> FindDatabase(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored))
    return path.extension() == ".db" ? std::optional(path) : std::nullopt;
  std::optional<fs::path> only;
  for (const std::string& name : dataset::ListFiles(path)) {
    if (!name.ends_with(".db")) continue;
    if (only) return std::nullopt;
    only = path / name;
  }
  return only;
}

bool IsSqlite(const fs::path& file) {
  constexpr std::string_view kMagic = "SQLite format 3";
  const Result<std::string> begin = dataset::ReadFilePiece(file, 0, kMagic.size());
  return begin && *begin == kMagic;
}

// The first node's images say what all are.
struct FirstNode {
  formats::NodeCamera camera;
  dataset::ImageSize colour;
  dataset::ImageSize depth;
};

Result<FirstNode> ReadFirst(const formats::RtabMapDatabase& database,
                            const formats::Node& node,
                            const fs::path& file) {
  const Result<formats::NodeImages> images = database.Images(node.id);
  if (!images) return images.error();
  const auto fault = [&](std::string_view what) {
    return InvalidInput(fmt::format("{}, node {}: {}", file.string(), node.id, what));
  };
  const Result<formats::NodeCamera> camera = formats::ParseNodeCamera(images->calibration);
  if (!camera) return fault(camera.error().message);
  const image_codec::ImageStructure colour = image_codec::StructureOf(images->colour);
  const image_codec::ImageStructure depth = image_codec::StructureOf(images->depth);
  if (colour.width < 1 || colour.height < 1)
    return fault("colour is neither a PNG nor a JPEG image");
  if (depth.width < 1 || depth.height < 1)
    return fault("depth is no PNG image (RVL is not read): export it by rtabmap-export");
  FirstNode first{*camera, {colour.width, colour.height}, {depth.width, depth.height}};
  PinholeCamera& own = first.camera.camera;
  if (own.width == 0) own.width = colour.width;
  if (own.height == 0) own.height = colour.height;
  const Status plausible = dataset::CheckCamera(own, file, "calibration");
  if (!plausible) return plausible.error();
  return first;
}

bool HasTimes(const std::vector<formats::Node>& nodes) {
  return std::ranges::adjacent_find(nodes, [](const formats::Node& a, const formats::Node& b) {
           return !(b.time_s > a.time_s);
         }) == nodes.end();
}

}  // namespace

LayoutMatch MatchRtabMapDatabase(const fs::path& path) {
  const std::optional<fs::path> file = FindDatabase(path);
  if (file && IsSqlite(*file)) return {true, 1, {}};
  return {false, 0, {"a file NAME.db"}};
}

Result<OpenedLayout> OpenRtabMapDatabase(const LayoutSource& source) {
  const fs::path file = FindDatabase(source.path).value_or(source.path);
  Result<std::unique_ptr<formats::RtabMapDatabase>> opened_database =
      formats::RtabMapDatabase::Open(file);
  if (!opened_database) return opened_database.error();
  const std::shared_ptr<formats::RtabMapDatabase> database = *std::move(opened_database);
  const Result<std::vector<formats::Node>> nodes = database->Nodes();
  if (!nodes) return nodes.error();
  if (nodes->empty()) {
    return InvalidInput(
        fmt::format("{}: holds no node with colour and depth; were images kept "
                    "(Mem/BinDataKept)?",
                    file.string()));
  }
  const Result<FirstNode> first = ReadFirst(*database, nodes->front(), file);
  if (!first) return first.error();
  const formats::NodeCamera& camera = first->camera;
  dataset::CaptureCameras cameras{camera.camera, camera.camera, Pose3(), kUnitsPerM};
  if (first->depth.width != camera.camera.width || first->depth.height != camera.camera.height) {
    const Result<PinholeCamera> depth = SameView(camera.camera, first->depth, file);
    if (!depth) return depth.error();
    cameras.depth = *depth;
  }
  OpenedLayout opened;
  opened.has_times = HasTimes(*nodes);
  std::vector<dataset::StoredFrame> frames;
  std::vector<std::int64_t> ids;
  for (const formats::Node& node : *nodes) {
    const double time_s =
        opened.has_times ? node.time_s : TimeOfNumber(static_cast<std::int64_t>(frames.size()));
    dataset::StoredFrame frame{time_s, time_s, fmt::format("{:06d}", node.id), std::nullopt};
    if (node.world_from_base)
      frame.world_from_colour = *node.world_from_base * camera.base_from_camera;
    frames.push_back(std::move(frame));
    ids.push_back(node.id);
  }
  Result<std::string> digest = dataset::HashLargeFile(file);
  if (!digest) return digest.error();
  Result<std::string> hash = dataset::HashFiles(
      "rtabmap-db",
      std::vector<dataset::NamedText>{{kSettingsName, source.settings_text}, {"database", *digest}},
      {},
      {});
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.poses_file = file.string();
  opened.optics = WithStated(source.settings, {camera.lens, camera.lens, {}, {}});
  if (!opened.has_times) opened.warnings.push_back(NoTimesWarning(file));
  opened.frames = std::make_shared<DatabaseFrames>(
      file, database, WithStated(source.settings, cameras), std::move(frames), std::move(ids));
  return opened;
}

}  // namespace deepslam::layouts
