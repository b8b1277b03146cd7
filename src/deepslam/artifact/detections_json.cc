#include "deepslam/artifact/detections_json.h"

#include <map>
#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/detections";
constexpr int kVersion = 2;
constexpr int kMaxImageSide = 1 << 15;

std::map<std::string, int> CategoryIds(const DetectionTable& table) {
  std::map<std::string, int> ids;
  for (const Detection& detection : table.detections) ids.emplace(detection.class_name, 0);
  int next = 1;
  for (auto& [class_name, id] : ids) id = next++;
  return ids;
}

JsonValue ImageToJson(const DetectedImage& image) {
  JsonObject row;
  row.emplace("id", ToJson(image.frame));
  row.emplace("file_name", image.file_name);
  row.emplace("width", image.width);
  row.emplace("height", image.height);
  if (image.contains_person) row.emplace("contains_person", *image.contains_person);
  return JsonValue(std::move(row));
}

DetectedImage ReadImage(const JsonNode& row) {
  DetectedImage image{ReadId<FrameIdx>(row["id"]),
                      row["file_name"].String(),
                      row["width"].Int(1, kMaxImageSide),
                      row["height"].Int(1, kMaxImageSide)};
  const JsonNode person = row.Maybe("contains_person");
  if (person.exists()) image.contains_person = person.Bool();
  return image;
}

JsonValue AnnotationToJson(const Detection& detection, int category_id) {
  JsonObject row;
  row.emplace("id", ToJson(detection.id));
  row.emplace("image_id", ToJson(detection.frame));
  row.emplace("category_id", category_id);
  row.emplace("category_name", detection.class_name);
  row.emplace("bbox", ToCocoBox(detection.box_px));
  row.emplace("area", detection.box_px.area_px());
  row.emplace("iscrowd", 0);
  row.emplace("score", detection.score);
  row.emplace("source", NameOf(detection.source));
  if (!detection.mask.empty()) row.emplace("segmentation", ToJson(detection.mask));
  return JsonValue(std::move(row));
}

Detection ReadAnnotation(const JsonNode& row) {
  Detection detection;
  detection.id = ReadId<DetectionId>(row["id"]);
  detection.frame = ReadId<FrameIdx>(row["image_id"]);
  detection.class_name = row["category_name"].String();
  detection.box_px = ReadCocoBox(row["bbox"]);
  detection.score = row["score"].Number(0, 1);
  detection.source = ReadDetectionSource(row["source"]);
  detection.mask = ReadMask(row.Maybe("segmentation"));
  return detection;
}

}  // namespace

Result<std::string> EncodeDetections(const DetectionTable& table, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("images", RowsOf(table.images, ImageToJson));
  const std::map<std::string, int> category_ids = CategoryIds(table);
  JsonArray categories;
  for (const auto& [class_name, id] : category_ids) {
    JsonObject row;
    row.emplace("id", id);
    row.emplace("name", class_name);
    categories.emplace_back(std::move(row));
  }
  const auto annotation = [&](std::size_t i) {
    const Detection& detection = table.detections[i];
    return AnnotationToJson(detection, category_ids.at(detection.class_name));
  };
  document.emplace("categories", std::move(categories));
  document.emplace("annotations", JsonRows{table.detections.size(), annotation});
  return DumpJson(std::move(document), name);
}

Result<DetectionTable> DecodeDetections(TextSource text, std::string_view name) {
  DetectionTable table;
  const JsonReader reader(std::move(text),
                          name,
                          kFormat,
                          kVersion,
                          {{"images", AppendRows(table.images, ReadImage)},
                           {"annotations", AppendRows(table.detections, ReadAnnotation)}});
  return reader.Finish(std::move(table));
}

}  // namespace deepslam::artifact
