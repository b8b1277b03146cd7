#include "deepslam/detect/yolo_heads.h"

#include <algorithm>
#include <cmath>

#include "deepslam/core/check.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/detect/grid_cells.h"

namespace deepslam::detect {
namespace {

// Exponent limit of a YOLOX side: e^8 cells are beyond any input.
constexpr float kMaxLogSide = 8.0F;
// Boxes relative to grid cells have centres within a few cells; those in pixels spread over the
// input.
constexpr double kLargestMedianOffset = 16.0;

std::string ShapeText(std::span<const std::vector<std::int64_t>> shapes) {
  std::string text;
  for (const std::vector<std::int64_t>& shape : shapes) {
    if (!text.empty()) text += ", ";
    for (std::size_t i = 0; i < shape.size(); ++i) {
      if (i > 0) text += 'x';
      text += std::to_string(shape[i]);
    }
    if (shape.empty()) text += "scalar";
  }
  if (text.empty()) text = "none";
  return text;
}

int CountClasses(std::int64_t num_rows, int num_names) {
  return num_names > 0 ? num_names : static_cast<int>(std::clamp<std::int64_t>(num_rows, 0, 9999));
}

struct Entry {
  float cx, cy, width, height;
  int label_idx;
  float score;
};

void AppendBox(const Entry& e, double min_score, std::vector<HeadBox>& boxes) {
  const bool finite = std::isfinite(e.cx) && std::isfinite(e.cy) && std::isfinite(e.width) &&
                      std::isfinite(e.height) && std::isfinite(e.score);
  if (!finite || e.score < static_cast<float>(min_score) || e.width <= 0 || e.height <= 0) return;
  const double half_width = 0.5 * e.width;
  const double half_height = 0.5 * e.height;
  boxes.push_back({e.label_idx,
                   std::min(1.0, static_cast<double>(e.score)),
                   {e.cx - half_width, e.cy - half_height, e.cx + half_width, e.cy + half_height},
                   {}});
}

std::vector<HeadBox> DecodeYoloV8(std::span<const float> output,
                                  const HeadLayout& layout,
                                  double min_score) {
  const auto n = static_cast<std::size_t>(layout.num_cells);
  const auto num_classes = static_cast<std::size_t>(layout.num_classes);
  std::vector<HeadBox> boxes;
  for (std::size_t a = 0; a < n; ++a) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < num_classes; ++c) {
      if (output[(4 + c) * n + a] > output[(4 + best) * n + a]) best = c;
    }
    const std::size_t before = boxes.size();
    AppendBox({output[a],
               output[n + a],
               output[2 * n + a],
               output[3 * n + a],
               static_cast<int>(best),
               output[(4 + best) * n + a]},
              min_score,
              boxes);
    if (boxes.size() == before) continue;
    for (std::size_t m = 0; m < static_cast<std::size_t>(layout.num_coefficients); ++m) {
      boxes.back().coefficients.push_back(output[(4 + num_classes + m) * n + a]);
    }
  }
  return boxes;
}

bool IsRelativeToGrid(std::span<const float> output, std::size_t num_cells, std::size_t stride) {
  std::vector<float> centres;
  for (std::size_t a = 0; a < num_cells; ++a) {
    const float cx = output[a * stride];
    if (std::isfinite(cx)) centres.push_back(std::abs(cx));
  }
  if (centres.empty()) return true;
  return Median(centres) < kLargestMedianOffset;
}

std::vector<HeadBox> DecodeYoloX(std::span<const float> output,
                                 const HeadLayout& layout,
                                 double min_score) {
  const auto n = static_cast<std::size_t>(layout.num_cells);
  const auto num_classes = static_cast<std::size_t>(layout.num_classes);
  const std::size_t stride = 5 + num_classes;
  const bool relative = IsRelativeToGrid(output, n, stride);
  const std::vector<GridCell> cells = GridCells({layout.input_width, layout.input_height});
  std::vector<HeadBox> boxes;
  for (std::size_t a = 0; a < n; ++a) {
    const std::span<const float> row = output.subspan(a * stride, stride);
    const auto best =
        static_cast<std::size_t>(std::max_element(row.begin() + 5, row.end()) - (row.begin() + 5));
    Entry e = {row[0], row[1], row[2], row[3], static_cast<int>(best), row[4] * row[5 + best]};
    if (relative) {
      const auto cell_px = static_cast<float>(cells[a].stride);
      e.cx = (e.cx + static_cast<float>(cells[a].u)) * cell_px;
      e.cy = (e.cy + static_cast<float>(cells[a].v)) * cell_px;
      e.width = std::exp(std::min(e.width, kMaxLogSide)) * cell_px;
      e.height = std::exp(std::min(e.height, kMaxLogSide)) * cell_px;
    }
    AppendBox(e, min_score, boxes);
  }
  return boxes;
}

}  // namespace

Result<HeadLayout> RecogniseHead(std::span<const std::vector<std::int64_t>> output_shapes,
                                 int num_names,
                                 int input_width,
                                 int input_height) {
  HeadLayout layout;
  layout.input_width = input_width;
  layout.input_height = input_height;
  const std::int64_t num_cells = NumCells({input_width, input_height});
  const bool three =
      !output_shapes.empty() && output_shapes[0].size() == 3 && output_shapes[0][0] == 1;
  const std::int64_t rows = three ? output_shapes[0][1] : 0;
  const std::int64_t columns = three ? output_shapes[0][2] : 0;
  layout.num_cells = static_cast<int>(num_cells);
  if (output_shapes.size() == 1 && columns == num_cells && rows > 4) {
    layout.kind = HeadKind::kYoloV8;
    layout.num_classes = CountClasses(rows - 4, num_names);
    if (rows == 4 + layout.num_classes) return layout;
  }
  if (output_shapes.size() == 1 && rows == num_cells && columns > 5) {
    layout.kind = HeadKind::kYoloX;
    layout.num_classes = CountClasses(columns - 5, num_names);
    if (columns == 5 + layout.num_classes) return layout;
  }
  if (output_shapes.size() == 2 && columns == num_cells && output_shapes[1].size() == 4 &&
      output_shapes[1][0] == 1) {
    const std::vector<std::int64_t>& prototypes = output_shapes[1];
    const bool sane = std::all_of(prototypes.begin(), prototypes.end(), [](std::int64_t side) {
      return side > 0 && side <= 4096;
    });
    layout.kind = HeadKind::kYoloV8Seg;
    layout.num_classes = CountClasses(rows - 4 - prototypes[1], num_names);
    if (sane && layout.num_classes > 0 && rows == 4 + layout.num_classes + prototypes[1]) {
      layout.num_coefficients = static_cast<int>(prototypes[1]);
      layout.prototype_height = static_cast<int>(prototypes[2]);
      layout.prototype_width = static_cast<int>(prototypes[3]);
      return layout;
    }
  }
  return InvalidInput(
      "the network's head is not known: outputs " + ShapeText(output_shapes) + " for an input of " +
      std::to_string(input_width) + "x" + std::to_string(input_height) + " and " +
      std::to_string(num_names) + " labels; known are YOLOv8/YOLO11 (1x(4+classes)x" +
      std::to_string(num_cells) + "), their -seg variants (a second output 1xMxhxw) and YOLOX (1x" +
      std::to_string(num_cells) + "x(5+classes))");
}

std::vector<HeadBox> DecodeHead(std::span<const float> output,
                                const HeadLayout& layout,
                                double min_score) {
  const bool yolox = layout.kind == HeadKind::kYoloX;
  const auto rows =
      static_cast<std::size_t>((yolox ? 5 : 4) + layout.num_classes + layout.num_coefficients);
  DEEPSLAM_CHECK(output.size() == rows * static_cast<std::size_t>(layout.num_cells),
                 "output has not the layout's size");
  std::vector<HeadBox> boxes =
      yolox ? DecodeYoloX(output, layout, min_score) : DecodeYoloV8(output, layout, min_score);
  std::stable_sort(boxes.begin(), boxes.end(), [](const HeadBox& a, const HeadBox& b) {
    return a.score > b.score;
  });
  return boxes;
}

std::vector<HeadBox> SuppressOverlaps(std::vector<HeadBox> boxes, double max_iou, int max_boxes) {
  std::vector<HeadBox> kept;
  for (HeadBox& box : boxes) {
    if (static_cast<int>(kept.size()) >= max_boxes) break;
    const bool repeated = std::any_of(kept.begin(), kept.end(), [&](const HeadBox& better) {
      return better.label_idx == box.label_idx &&
             IntersectionOverUnion(better.box_input, box.box_input) > max_iou;
    });
    if (!repeated) kept.push_back(std::move(box));
  }
  return kept;
}

Mask DecodeInstanceMask(std::span<const float> coefficients,
                        std::span<const float> prototypes,
                        const HeadLayout& layout,
                        const Letterbox& letterbox,
                        const Box2& box_px,
                        int image_width,
                        int image_height) {
  const int width = layout.prototype_width;
  const int height = layout.prototype_height;
  const std::size_t plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  DEEPSLAM_CHECK(prototypes.size() == plane * coefficients.size(), "prototypes do not fit");
  std::vector<float> logits(plane, 0.0F);
  for (std::size_t m = 0; m < coefficients.size(); ++m) {
    for (std::size_t i = 0; i < plane; ++i)
      logits[i] += coefficients[m] * prototypes[m * plane + i];
  }
  const double per_u = static_cast<double>(width) / layout.input_width;
  const double per_v = static_cast<double>(height) / layout.input_height;
  const auto at = [&](int x, int y) {
    return static_cast<double>(
        logits[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x)]);
  };
  Mask mask(image_width, image_height);
  const Box2 box = Intersection(box_px, {0, 0, image_width - 1.0, image_height - 1.0});
  if (box.empty()) return mask;
  for (int v = static_cast<int>(std::ceil(box.v_min)); v <= static_cast<int>(box.v_max); ++v) {
    const double y = std::clamp(
        ((v + 0.5) * letterbox.scale + letterbox.pad_v_px) * per_v - 0.5, 0.0, height - 1.0);
    const int y0 = static_cast<int>(y);
    const int y1 = std::min(y0 + 1, height - 1);
    for (int u = static_cast<int>(std::ceil(box.u_min)); u <= static_cast<int>(box.u_max); ++u) {
      const double x = std::clamp(
          ((u + 0.5) * letterbox.scale + letterbox.pad_u_px) * per_u - 0.5, 0.0, width - 1.0);
      const int x0 = static_cast<int>(x);
      const int x1 = std::min(x0 + 1, width - 1);
      const double top = at(x0, y0) + (x - x0) * (at(x1, y0) - at(x0, y0));
      const double low = at(x0, y1) + (x - x0) * (at(x1, y1) - at(x0, y1));
      mask(u, v) = top + (y - y0) * (low - top) > 0 ? 1 : 0;  // sigmoid > 0.5
    }
  }
  return mask;
}

}  // namespace deepslam::detect
