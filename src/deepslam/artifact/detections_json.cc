#include "deepslam/artifact/detections_json.h"

#include <map>
#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr JsonFormat kFormat{"deepslam/detections", 2};
constexpr JsonFormat kDoubtsFormat{"deepslam/doubts", 1};
constexpr Range kImageSide{1, 1 << 15};

// COCO's numbers of the classes, by their names.
std::map<std::string, int> CategoryIds(const DetectionTable& table) {
  std::map<std::string, int> ids;
  for (const Detection& detection : table.detections) ids.emplace(detection.class_name, 0);
  int next = 1;
  for (auto& [class_name, id] : ids) id = next++;
  return ids;
}

JsonValue Categories(const std::map<std::string, int>& ids) {
  JsonArray categories;
  for (const auto& [class_name, id] : ids) {
    JsonObject row;
    row.emplace("id", id);
    row.emplace("name", class_name);
    categories.emplace_back(std::move(row));
  }
  return JsonValue(std::move(categories));
}

void DescribeDoubts(JsonVisitor& visitor, std::vector<std::string>& doubts) {
  visitor.Field("doubts", doubts);
}

}  // namespace

void Describe(JsonVisitor& visitor, DetectedImage& image) {
  visitor.Field("id", image.frame);
  visitor.Field("file_name", image.file_name);
  visitor.Field("width", image.width, kImageSide);
  visitor.Field("height", image.height, kImageSide);
  visitor.Maybe("contains_person", image.contains_person, image.contains_person.has_value());
}

void Describe(JsonVisitor& visitor, Detection& detection) {
  visitor.Field("id", detection.id);
  visitor.Field("image_id", detection.frame);
  visitor.Field("category_name", detection.class_name);
  visitor.Field("bbox", detection.box_px);
  visitor.Field("score", detection.score, kShare);
  visitor.Field("source", detection.source);
  visitor.Maybe("segmentation", detection.mask, !detection.mask.empty());
  visitor.WriteOnly("area", detection.box_px.area_px());
  visitor.WriteOnly("iscrowd", 0);
}

void Describe(JsonVisitor& visitor, DetectionTable& table) {
  visitor.Table("images", table.images);
  const std::map<std::string, int> ids =
      visitor.writing() ? CategoryIds(table) : std::map<std::string, int>();
  visitor.WriteOnly("categories", Categories(ids));
  visitor.Table("annotations", table.detections, [ids](JsonVisitor& row, Detection& detection) {
    Describe(row, detection);
    if (row.writing()) row.WriteOnly("category_id", ids.at(detection.class_name));
  });
}

Result<std::string> EncodeDetections(const DetectionTable& table, std::string_view name) {
  return EncodeDocument(kFormat, table, name);
}

Result<DetectionTable> DecodeDetections(TextSource text, std::string_view name) {
  return DecodeDocument<DetectionTable>(kFormat, std::move(text), name);
}

Result<std::string> EncodeDoubts(const std::vector<std::string>& doubts, std::string_view name) {
  return EncodeDocument(kDoubtsFormat, doubts, name, DescribeDoubts);
}

Result<std::vector<std::string>> DecodeDoubts(TextSource text, std::string_view name) {
  return DecodeDocument<std::vector<std::string>>(
      kDoubtsFormat, std::move(text), name, DescribeDoubts);
}

}  // namespace deepslam::artifact
