#include "deepslam/artifact/coco_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/frames/run_lengths.h"

namespace deepslam::artifact {
namespace {

constexpr std::size_t kMaxWarnings = 7;   // with the rest as many as a console shows
constexpr int kMaxCocoSidePx = 1 << 16;   // nobody's images are larger
constexpr double kMaxScaleSpread = 0.02;  // between width and height

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

// 0 for what is no image's side.
int SidePx(const JsonNode& node) {
  const double side = node.is_number() ? node.Number() : 0;
  const bool fits = side >= 1 && side <= kMaxCocoSidePx && side == std::floor(side);
  return fits ? static_cast<int>(side) : 0;
}

PictureSize KnownSize(int width, int height) {
  return width > 0 && height > 0 ? PictureSize{width, height} : PictureSize();
}

PictureSize SizeOfRow(const JsonNode& row) {
  return KnownSize(SidePx(row.Maybe("width")), SidePx(row.Maybe("height")));
}

PictureSize SizeOfMask(const JsonNode& segmentation) {
  const JsonNode size = segmentation.Maybe("size");
  const std::vector<JsonNode> sides = size.is_array() ? size.Items() : std::vector<JsonNode>();
  return sides.size() == 2 ? KnownSize(SidePx(sides[1]), SidePx(sides[0])) : PictureSize();
}

PictureSize SizeOfFrame(const DetectedImage& image) { return {image.width, image.height}; }

double ToFrame(double at, int frame_side, int image_side) {
  if (frame_side == image_side) return at;
  return (at + 0.5) * frame_side / image_side - 0.5;
}

Box2 ToFrame(const Box2& box, const PictureSize& frame, const PictureSize& size) {
  return {ToFrame(box.u_min, frame.width, size.width),
          ToFrame(box.v_min, frame.height, size.height),
          ToFrame(box.u_max, frame.width, size.width),
          ToFrame(box.v_max, frame.height, size.height)};
}

// The compressed text of `counts`, which COCO writes as a text or as a list of runs.
Result<std::string> RleOf(const JsonNode& counts, const PictureSize& size) {
  if (counts.is_string()) return counts.String();
  if (!counts.is_array())
    return InvalidInput("has no counts: neither COCO's text of run lengths nor a list of them");
  std::vector<std::int64_t> runs;
  for (const JsonNode& item : counts.Items()) {
    const double run = item.is_number() ? item.Number() : -1;
    if (!(run >= 0 && run <= kMaxMaskPixels && run == std::floor(run))) {
      return InvalidInput(fmt::format(
          "mask's run {} is no number of pixels, 0 to {}", runs.size(), kMaxMaskPixels));
    }
    runs.push_back(static_cast<std::int64_t>(run));
  }
  return RleOfRuns(runs, size.width, size.height);
}

class CocoReader {
 public:
  CocoReader(std::span<const DetectedImage> images,
             const ClassTable& classes,
             const PictureSize& colour)
      : classes_(classes), colour_(colour) {
    for (const DetectedImage& image : images) {
      by_stem_.emplace(Stem(image.file_name), &image);
      by_frame_.emplace(image.frame.value, &image);
    }
    for (const auto& [id, label] : kCocoIds) labels_[std::to_string(id)] = label;
  }

  // What the document says of images and categories.
  Status ReadTables(TextSource text, std::string_view name) {
    std::map<std::string, std::string> labels;
    const auto read_images = [&](std::span<const JsonNode> rows) {
      for (const JsonNode& row : rows) ReadImage(row);
    };
    const auto read_categories = [&](std::span<const JsonNode> rows) {
      for (const JsonNode& row : rows) {
        const JsonNode label = row.Maybe("name");
        if (label.is_string()) labels[IdText(row.Maybe("id"))] = label.String();
      }
    };
    JsonReader reader(std::move(text),
                      name,
                      "",
                      0,
                      {{"images", read_images, false},
                       {"categories", read_categories, false},
                       {"annotations", Skip, false},
                       {"", Skip, false}});
    if (!reader.ok()) return reader.error();
    const JsonNode root = reader.root();
    if (!root.is_array() && !root.is_object()) {
      return InvalidInput(
          fmt::format("{}: is neither a COCO results list nor a COCO dataset", name));
    }
    if (root.is_object() && root.Maybe("categories").is_array()) labels_ = std::move(labels);
    return Ok();
  }

  Status ReadEntries(TextSource text, std::string_view name) {
    const auto read = [&](std::span<const JsonNode> entries) {
      for (const JsonNode& entry : entries) {
        ++found_.losses.num_entries;
        if (entry.is_object()) {
          ReadEntry(entry);
        } else {
          LeaveOut(entry, CocoFault::kNoObject, "is no object");
        }
      }
    };
    JsonReader reader(std::move(text),
                      name,
                      "",
                      0,
                      {{"images", Skip, false}, {"annotations", read, false}, {"", read, false}});
    if (reader.ok() && reader.root().is_object()) (void)reader.root()["annotations"].Items();
    return reader.ok() ? Ok() : Status(reader.error());
  }

  CocoDetections Take() {
    if (num_untold_ > 0)
      found_.warnings.push_back(fmt::format("and {} more faults of such kinds", num_untold_));
    if (!scale_warning_.empty()) found_.warnings.insert(found_.warnings.begin(), scale_warning_);
    std::stable_sort(found_.detections.begin(),
                     found_.detections.end(),
                     [](const Detection& a, const Detection& b) { return a.frame < b.frame; });
    return std::move(found_);
  }

 private:
  static void Skip(std::span<const JsonNode> /*rows*/) {}

  void ReadImage(const JsonNode& row) {
    const std::string id = IdText(row.Maybe("id"));
    const PictureSize size = SizeOfRow(row);
    sizes_[id] = size;
    const JsonNode file_name = row.Maybe("file_name");
    if (!file_name.is_string()) return;
    const std::string stem = Stem(file_name.String());
    document_images_[id] = stem;
    stem_sizes_[stem] = size;
  }

  // Of the image in which the boxes of an entry were found.
  PictureSize SizeOf(const JsonNode& entry, const DetectedImage& image) const {
    const PictureSize frame = SizeOfFrame(image);
    PictureSize size;
    if (const auto row = sizes_.find(IdText(entry.Maybe("image_id"))); row != sizes_.end()) {
      size = row->second;
    } else if (const auto named = stem_sizes_.find(Stem(image.file_name));
               named != stem_sizes_.end()) {
      size = named->second;
    }
    if (size != PictureSize()) return size;
    if (SizeOfMask(entry.Maybe("segmentation")) == frame) return frame;
    return colour_ != PictureSize() ? colour_ : frame;
  }

  const DetectedImage* FindImage(const JsonNode& image_id) const {
    const std::string id = IdText(image_id);
    std::string stem = image_id.is_string() ? Stem(id) : std::string();
    if (const auto named = document_images_.find(id); named != document_images_.end())
      stem = named->second;
    if (const auto it = by_stem_.find(stem); !stem.empty() && it != by_stem_.end())
      return it->second;
    if (!document_images_.empty() || !image_id.is_number()) return nullptr;
    const auto it = by_frame_.find(image_id.Number());
    return it == by_frame_.end() ? nullptr : it->second;
  }

  // Nothing for a category that has no name.
  std::optional<std::string> Label(const JsonNode& entry) const {
    if (const JsonNode label = entry.Maybe("category_name"); label.is_string())
      return label.String();
    const auto it = labels_.find(IdText(entry.Maybe("category_id")));
    return it == labels_.end() ? std::nullopt : std::optional(it->second);
  }

  // Null where the entry is left out.
  const ObjectClass* FindClass(const JsonNode& entry) {
    const std::optional<std::string> label = Label(entry);
    if (!label) {
      const std::string id = IdText(entry.Maybe("category_id"));
      LeaveOut(entry,
               CocoFault::kNamelessCategory,
               id.empty() ? "has neither a category_name nor a category_id"
                          : fmt::format("has category_id {}, which has no name", id));
      return nullptr;
    }
    const ObjectClass* object_class = classes_.FindByLabel(*label);
    if (object_class == nullptr) object_class = classes_.Find(*label);
    if (object_class == nullptr) {
      LeaveOut(entry,
               CocoFault::kUnknownClass,
               fmt::format("has class \"{}\", which the class table does not know", *label));
    }
    return object_class;
  }

  void ReadEntry(const JsonNode& entry) {
    const DetectedImage* image = FindImage(entry.Maybe("image_id"));
    if (image == nullptr)
      return LeaveOut(entry, CocoFault::kUnknownImage, "belongs to no frame of the capture");
    const ObjectClass* object_class = FindClass(entry);
    if (object_class == nullptr) return;
    const PictureSize size = SizeOf(entry, *image);
    CheckScale(size, *image);
    const std::optional<Box2> box = ReadBox(entry.Maybe("bbox"), SizeOfFrame(*image), size);
    if (!box) {
      return LeaveOut(entry,
                      CocoFault::kUnusableBox,
                      "has no usable bbox [x, y, width, height] inside the image");
    }
    Detection detection;
    detection.frame = image->frame;
    detection.class_name = object_class->name;
    detection.box_px = *box;
    detection.source = DetectionSource::kFile;
    const JsonNode score = entry.Maybe("score");
    detection.score = score.is_number() ? score.Number() : 1.0;
    if (!(detection.score >= 0 && detection.score <= 1)) {
      return LeaveOut(entry, CocoFault::kUnusableScore, "has a score outside [0, 1]");
    }
    ReadMask(entry.Maybe("segmentation"), SizeOfFrame(*image), size, detection);
    found_.detections.push_back(std::move(detection));
  }

  void CheckScale(const PictureSize& size, const DetectedImage& image) {
    const double spread = (1.0 * size.width * image.height) / (1.0 * size.height * image.width);
    if (!scale_warning_.empty() || std::max(spread, 1 / spread) <= 1 + kMaxScaleSpread) return;
    scale_warning_ = fmt::format(
        "boxes of \"{}\" are of an image of {} x {} px, its frame has {} x {}: width and height "
        "scale differently, and boxes may lie wrong; were they found in this capture's images?",
        image.file_name,
        size.width,
        size.height,
        image.width,
        image.height);
  }

  static std::optional<Box2> ReadBox(const JsonNode& node,
                                     const PictureSize& frame,
                                     const PictureSize& size) {
    if (!node.is_array()) return std::nullopt;
    const std::vector<JsonNode> items = node.Items();
    if (items.size() != 4) return std::nullopt;
    for (const JsonNode& item : items) {
      if (!item.is_number() || !(std::abs(item.Number()) < 1e6)) return std::nullopt;
    }
    const double u = items[0].Number();
    const double v = items[1].Number();
    const Box2 found{u, v, u + items[2].Number(), v + items[3].Number()};
    const Box2 whole{0, 0, frame.width - 1.0, frame.height - 1.0};
    const Box2 box = Intersection(ToFrame(found, frame, size), whole);
    if (box.width_px() < 1 || box.height_px() < 1) return std::nullopt;
    return box;
  }

  // A mask that cannot be used leaves the box in force.
  void ReadMask(const JsonNode& node,
                const PictureSize& frame,
                const PictureSize& size,
                Detection& detection) {
    if (!node.is_object()) return;  // polygons: the box has to do
    ++found_.losses.num_masks;
    if (!node.Maybe("size").is_array())
      return LeaveMaskOut(node, "is no run-length mask: it has no size [height, width]");
    if (SizeOfMask(node) != size) {
      return LeaveMaskOut(
          node, fmt::format("is not of the image's size {} x {}", size.width, size.height));
    }
    const Result<std::string> rle = RleOf(node.Maybe("counts"), size);
    if (!rle.ok()) return LeaveMaskOut(node, rle.error().message);
    Result<Mask> mask =
        size == frame ? DecodeRle(*rle, size.width, size.height)
                      : DecodeRleResized(*rle, size.width, size.height, frame.width, frame.height);
    if (!mask.ok()) return LeaveMaskOut(node, mask.error().message);
    if (std::ranges::find(*mask, 1) == mask->end())
      return LeaveMaskOut(node, "is a mask without a pixel");
    detection.mask = *mask;
  }

  void LeaveOut(const JsonNode& entry, CocoFault fault, std::string_view what) {
    CocoLosses::Kind& kind = found_.losses.Of(fault);
    if (kind.num_entries++ == 0) kind.first = fmt::format("{} {}", entry.path(), what);
    Warn(entry, what);
  }

  void LeaveMaskOut(const JsonNode& node, std::string_view what) {
    ++found_.losses.num_unusable_masks;
    Warn(node, what);
  }

  void Warn(const JsonNode& node, std::string_view what) {
    if (found_.warnings.size() < kMaxWarnings) {
      found_.warnings.push_back(fmt::format("{} {}", node.path(), what));
    } else {
      ++num_untold_;
    }
  }

  const ClassTable& classes_;
  PictureSize colour_;
  std::map<std::string, const DetectedImage*> by_stem_;
  std::map<double, const DetectedImage*> by_frame_;     // as documents number images
  std::map<std::string, std::string> document_images_;  // id -> stem
  std::map<std::string, PictureSize> sizes_;            // id -> what the document says
  std::map<std::string, PictureSize> stem_sizes_;
  std::map<std::string, std::string> labels_;  // category id -> label
  std::string scale_warning_;
  int num_untold_ = 0;  // faults
  CocoDetections found_;
};

}  // namespace

Result<CocoDetections> ReadCocoFile(const OpenedText& open,
                                    std::string_view name,
                                    std::span<const DetectedImage> images,
                                    const ClassTable& classes,
                                    const PictureSize& colour) {
  CocoReader reader(images, classes, colour);
  for (const auto read : {&CocoReader::ReadTables, &CocoReader::ReadEntries}) {
    Result<TextSource> text = open();
    if (!text.ok()) return text.error();
    if (Status status = (reader.*read)(std::move(text).value(), name); !status.ok())
      return status.error();
  }
  return reader.Take();
}

}  // namespace deepslam::artifact
