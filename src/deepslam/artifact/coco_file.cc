#include "deepslam/artifact/coco_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/rle.h"

namespace deepslam::artifact {
namespace {

constexpr std::size_t kMaxWarnings = 10;

// COCO's category ids of indoor things; the table of classes decides which of them mean something.
constexpr std::array<std::pair<int, std::string_view>, 12> kCocoIds = {{{15, "bench"},
                                                                        {62, "chair"},
                                                                        {63, "couch"},
                                                                        {64, "potted plant"},
                                                                        {65, "bed"},
                                                                        {67, "dining table"},
                                                                        {70, "toilet"},
                                                                        {72, "tv"},
                                                                        {78, "microwave"},
                                                                        {79, "oven"},
                                                                        {81, "sink"},
                                                                        {82, "refrigerator"}}};

std::string Stem(std::string_view file_name) {
  return std::filesystem::path(file_name).stem().string();
}

// Integers and strings both name images and categories in the wild; compared as text.
std::string IdText(const JsonNode& node) {
  if (node.is_string()) return node.String();
  if (node.is_number()) return ShortestDecimal(node.Number());
  return {};
}

class CocoReader {
 public:
  CocoReader(JsonReader& reader, std::span<const DetectedImage> images, const ClassTable& classes)
      : reader_(reader), images_(images), classes_(classes) {
    for (const DetectedImage& image : images) by_stem_.emplace(Stem(image.file_name), &image);
    for (const auto& [id, label] : kCocoIds) labels_[std::to_string(id)] = label;
  }

  CocoDetections Read() {
    const JsonNode root = reader_.root();
    JsonNode entries = root;
    if (root.is_object()) {
      ReadTables(root);
      entries = root["annotations"];
    }
    for (const JsonNode& entry : entries.Items()) {
      if (entry.is_object()) {
        ReadEntry(entry);
      } else {
        Warn(entry, "is no object", found_.num_unusable);
      }
    }
    std::stable_sort(found_.detections.begin(),
                     found_.detections.end(),
                     [](const Detection& a, const Detection& b) { return a.frame < b.frame; });
    return std::move(found_);
  }

 private:
  void ReadTables(const JsonNode& root) {
    if (const JsonNode images = root.Maybe("images"); images.is_array()) {
      for (const JsonNode& row : images.Items()) {
        const JsonNode file_name = row.Maybe("file_name");
        if (file_name.is_string())
          document_images_[IdText(row.Maybe("id"))] = Stem(file_name.String());
      }
    }
    if (const JsonNode categories = root.Maybe("categories"); categories.is_array()) {
      labels_.clear();
      for (const JsonNode& row : categories.Items()) {
        const JsonNode label = row.Maybe("name");
        if (label.is_string()) labels_[IdText(row.Maybe("id"))] = label.String();
      }
    }
  }

  const DetectedImage* FindImage(const JsonNode& image_id) const {
    const std::string id = IdText(image_id);
    std::string stem = image_id.is_string() ? Stem(id) : std::string();
    if (const auto named = document_images_.find(id); named != document_images_.end())
      stem = named->second;
    if (const auto it = by_stem_.find(stem); !stem.empty() && it != by_stem_.end())
      return it->second;
    if (!document_images_.empty() || !image_id.is_number()) return nullptr;
    const double idx = image_id.Number();
    const auto it = std::find_if(images_.begin(), images_.end(), [&](const DetectedImage& image) {
      return image.frame.value == idx;
    });
    return it == images_.end() ? nullptr : &*it;
  }

  std::string Label(const JsonNode& entry) const {
    if (const JsonNode label = entry.Maybe("category_name"); label.is_string())
      return label.String();
    const auto it = labels_.find(IdText(entry.Maybe("category_id")));
    return it == labels_.end() ? std::string() : it->second;
  }

  void ReadEntry(const JsonNode& entry) {
    const DetectedImage* image = FindImage(entry.Maybe("image_id"));
    if (image == nullptr)
      return Warn(entry, "belongs to no frame of the capture", found_.num_unknown_image);
    const std::string label = Label(entry);
    const ObjectClass* object_class = classes_.FindByLabel(label);
    if (object_class == nullptr) object_class = classes_.Find(label);
    if (object_class == nullptr) {
      return Warn(entry,
                  fmt::format("has class \"{}\", which the class table does not know", label),
                  found_.num_unknown_class);
    }
    const std::optional<Box2> box = ReadBox(entry.Maybe("bbox"), *image);
    if (!box)
      return Warn(
          entry, "has no usable bbox [x, y, width, height] inside the image", found_.num_unusable);
    Detection detection;
    detection.frame = image->frame;
    detection.class_name = object_class->name;
    detection.box_px = *box;
    detection.source = DetectionSource::kFile;
    const JsonNode score = entry.Maybe("score");
    detection.score = score.is_number() ? score.Number() : 1.0;
    if (!(detection.score >= 0 && detection.score <= 1)) {
      return Warn(entry, "has a score outside [0, 1]", found_.num_unusable);
    }
    ReadMask(entry.Maybe("segmentation"), *image, detection);
    found_.detections.push_back(std::move(detection));
  }

  static std::optional<Box2> ReadBox(const JsonNode& node, const DetectedImage& image) {
    if (!node.is_array()) return std::nullopt;
    const std::vector<JsonNode> items = node.Items();
    if (items.size() != 4) return std::nullopt;
    for (const JsonNode& item : items) {
      if (!item.is_number() || !(std::abs(item.Number()) < 1e6)) return std::nullopt;
    }
    const double u = items[0].Number();
    const double v = items[1].Number();
    const Box2 whole{0, 0, image.width - 1.0, image.height - 1.0};
    const Box2 box = Intersection({u, v, u + items[2].Number(), v + items[3].Number()}, whole);
    if (box.width_px() < 1 || box.height_px() < 1) return std::nullopt;
    return box;
  }

  // A mask that cannot be used leaves the box in force.
  void ReadMask(const JsonNode& node, const DetectedImage& image, Detection& detection) {
    if (!node.is_object()) return;  // polygons: the box has to do
    const JsonNode size = node.Maybe("size");
    const JsonNode counts = node.Maybe("counts");
    if (!size.is_array() || !counts.is_string())
      return Warn(node, "is no run-length mask", found_.num_unusable);
    const std::vector<JsonNode> sides = size.Items();
    if (sides.size() != 2 || !sides[0].is_number() || !sides[1].is_number() ||
        sides[0].Number() != image.height || sides[1].Number() != image.width) {
      return Warn(node,
                  fmt::format("is not of the image's size {} x {}", image.width, image.height),
                  found_.num_unusable);
    }
    Result<Mask> mask = DecodeRle(counts.String(), image.width, image.height);
    if (!mask.ok()) return Warn(node, mask.error().message, found_.num_unusable);
    detection.mask = *mask;
  }

  void Warn(const JsonNode& node, std::string_view what, int& counter) {
    ++counter;
    if (found_.warnings.size() < kMaxWarnings)
      found_.warnings.push_back(fmt::format("{} {}", node.path(), what));
  }

  JsonReader& reader_;
  std::span<const DetectedImage> images_;
  const ClassTable& classes_;
  std::map<std::string, const DetectedImage*> by_stem_;
  std::map<std::string, std::string> document_images_;  // id -> stem
  std::map<std::string, std::string> labels_;           // category id -> label
  CocoDetections found_;
};

}  // namespace

Result<CocoDetections> ReadCocoFile(std::string_view text,
                                    std::string_view name,
                                    std::span<const DetectedImage> images,
                                    const ClassTable& classes) {
  JsonReader reader(text, name, "", 0);
  if (!reader.ok()) return reader.error();
  if (!reader.root().is_array() && !reader.root().is_object()) {
    return InvalidInput(fmt::format("{}: is neither a COCO results list nor a COCO dataset", name));
  }
  CocoDetections found = CocoReader(reader, images, classes).Read();
  return reader.Finish(std::move(found));
}

}  // namespace deepslam::artifact
