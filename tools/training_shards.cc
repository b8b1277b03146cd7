#include "training_shards.h"

#include <array>
#include <system_error>
#include <utility>

#include "deepslam/priors/npy.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCrop = propose::kCropSide;
constexpr std::size_t kSketch = priors::kSketchSide;

std::string PackBits(const VoxelGrid& grid) {
  std::string bytes(grid.occupied.size() / 8, '\0');
  for (std::size_t n = 0; n < grid.occupied.size(); ++n) {
    if (grid.occupied[n] != 0)
      bytes[n / 8] = static_cast<char>(static_cast<unsigned char>(bytes[n / 8]) | (0x80U >> n % 8));
  }
  return bytes;
}

}  // namespace

Result<TrainingShards> TrainingShards::Create(const fs::path& folder,
                                              std::size_t num_models,
                                              std::size_t num_views) {
  std::error_code code;
  if (fs::exists(folder, code) && !(fs::is_directory(folder, code) && fs::is_empty(folder, code))) {
    return InvalidConfig(folder.string() +
                         ": exists and is not an empty folder; name a new one or remove it");
  }
  TrainingShards shards;
  shards.folder_ = folder.has_filename() ? folder : folder.parent_path();
  shards.aside_ = shards.folder_.string() + ".partial";
  fs::remove_all(shards.aside_, code);
  if (Status status = storage::MakeFolders(shards.aside_); !status.ok()) return status.error();
  const std::size_t n = num_views;
  struct Array {
    std::string_view name;
    std::string_view dtype;
    std::vector<std::size_t> shape;
    std::string_view meaning;
  };
  const std::array<Array, 10> arrays = {{
      {"colour", "|u1", {n, kCrop, kCrop, 3}, "crop on white, RGB"},
      {"silhouette", "|u1", {n, kCrop, kCrop}, "share of the pixel, 0..255"},
      {"depth", "|u1", {n, kCrop, kCrop}, "0 unknown, else 128 + 127 (z - median) / side"},
      {"height", "|u1", {n, kCrop, kCrop}, "above the ground: cm + 10"},
      {"sketch_depth", "|u1", {n, kSketch, kSketch}, "of the whole object, as depth"},
      {"sketch_normal", "|u1", {n, kSketch, kSketch, 3}, "128 + 127 n, camera axes"},
      {"sketch_silhouette", "|u1", {n, kSketch, kSketch}, "of the whole object, 0 or 255"},
      {"camera",
       "<f4",
       {n, 7},
       "azimuth, elevation, distance, longest side, visible share, crop's side over focal "
       "length, elevation by the ground (-10: unknown)"},
      {"model", "<i4", {n}, "row of voxels"},
      {"voxels", "|u1", {num_models, kGridSize * kGridSize * kGridSize / 8}, "packed bits"},
  }};
  for (const Array& array : arrays) {
    if (Status status = shards.Open(array.name, array.dtype, array.shape, array.meaning);
        !status.ok())
      return status.error();
  }
  return shards;
}

Status TrainingShards::Open(std::string_view name,
                            std::string_view dtype,
                            std::vector<std::size_t> shape,
                            std::string_view meaning) {
  const fs::path file = aside_ / (std::string(name) + ".npy");
  std::ofstream& out = files_[std::string(name)];
  out.open(file, std::ios::binary | std::ios::trunc);
  const std::string header = priors::NpyHeader(dtype, shape);
  out.write(header.data(), static_cast<std::streamsize>(header.size()));
  if (!out) return Failed(file.string() + ": cannot be written");
  artifact::JsonArray sides;
  for (const std::size_t side : shape) sides.emplace_back(static_cast<std::int64_t>(side));
  artifact::JsonObject entry;
  entry.emplace("dtype", dtype);
  entry.emplace("shape", std::move(sides));
  entry.emplace("meaning", meaning);
  arrays_.emplace(std::string(name), std::move(entry));
  return Ok();
}

Status TrainingShards::Append(std::string_view name, const void* bytes, std::size_t count) {
  std::ofstream& out = files_.find(name)->second;
  out.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  if (!out)
    return Failed((aside_ / (std::string(name) + ".npy")).string() +
                  ": cannot be written; is the disk full?");
  return Ok();
}

Status TrainingShards::AddModel(const TrainingModel& model) {
  artifact::JsonObject entry;
  entry.emplace("id", model.id);
  entry.emplace("class", model.class_name);
  entry.emplace("kind", model.kind);
  entry.emplace("source", model.source);
  entry.emplace("split", model.split);
  entry.emplace("credit", model.credit);
  entry.emplace("symmetry", model.symmetry);
  entry.emplace("size_m",
                artifact::JsonArray{model.size_m.x(), model.size_m.y(), model.size_m.z()});
  models_.emplace_back(std::move(entry));
  const std::string bits = PackBits(model.shape);
  return Append("voxels", bits.data(), bits.size());
}

Status TrainingShards::AddView(const priors::TrainingView& view) {
  static_assert(sizeof(Rgb8) == 3);
  const auto model = static_cast<std::int32_t>(models_.size()) - 1;
  constexpr float kUnknown = -10;  // rad
  const std::array<float, 7> camera = {
      static_cast<float>(view.azimuth_rad),
      static_cast<float>(view.elevation_rad),
      static_cast<float>(view.distance_m),
      static_cast<float>(view.longest_side_m),
      static_cast<float>(view.visible),
      static_cast<float>(view.crop.camera.side),
      static_cast<float>(view.crop.elevation_rad.value_or(kUnknown))};
  const std::array<Status, 9> outcomes = {
      Append("colour", view.crop.colour.data(), 3 * view.crop.colour.size()),
      Append("silhouette", view.crop.silhouette.data(), view.crop.silhouette.size()),
      Append("depth", view.crop.depth.data(), view.crop.depth.size()),
      Append("height", view.crop.height.data(), view.crop.height.size()),
      Append("sketch_depth", view.sketch.depth.data(), view.sketch.depth.size()),
      Append("sketch_normal", view.sketch.normal.data(), 3 * view.sketch.normal.size()),
      Append("sketch_silhouette", view.sketch.silhouette.data(), view.sketch.silhouette.size()),
      Append("camera", camera.data(), sizeof(camera)),
      Append("model", &model, sizeof(model))};
  for (const Status& outcome : outcomes) {
    if (!outcome.ok()) return outcome;
  }
  return Ok();
}

Status TrainingShards::Finish(std::uint64_t seed, bool faults) {
  for (auto& [name, out] : files_) {
    out.close();
    if (!out) return Failed((aside_ / (name + ".npy")).string() + ": cannot be written");
  }
  artifact::JsonObject document;
  document.emplace("format", "deepslam/training_views");
  document.emplace("version", 2);
  document.emplace("seed", static_cast<std::int64_t>(seed));
  document.emplace("faults", faults);
  document.emplace("arrays", std::move(arrays_));
  document.emplace("models", std::move(models_));
  const Result<std::string> text = artifact::DumpJson(std::move(document), "training_views.json");
  if (!text.ok()) return text.error();
  if (Status status = storage::WriteFileSynced(aside_ / "training_views.json", *text); !status.ok())
    return status;
  std::error_code code;
  fs::remove(folder_, code);  // empty, or not there
  fs::rename(aside_, folder_, code);
  if (code)
    return Failed(folder_.string() + ": cannot be put in place (" + code.message() +
                  "); the views lie in " + aside_.string());
  return Ok();
}

}  // namespace deepslam::tools
