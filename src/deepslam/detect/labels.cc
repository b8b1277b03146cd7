#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/detect/yolo_heads.h"

namespace deepslam::detect {
namespace {

constexpr std::size_t kMostLabels = 10000;  // networks' metadata of more is refused

struct Quoted {
  std::string text;
  std::size_t end = std::string_view::npos;  // behind the closing quote; npos when there is none
};

// `start` is the position of the opening quote.
Quoted ReadQuoted(std::string_view text, std::size_t start) {
  Quoted quoted;
  for (std::size_t i = start + 1; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) {
      quoted.text += text[++i];
    } else if (text[i] == text[start]) {
      quoted.end = i + 1;
      return quoted;
    } else {
      quoted.text += text[i];
    }
  }
  return quoted;
}

}  // namespace

std::vector<std::string> ParseNames(std::string_view text) {
  const std::size_t open = text.find_first_not_of(" \t\r\n");
  if (open == std::string_view::npos || (text[open] != '{' && text[open] != '[')) return {};
  const bool dictionary = text[open] == '{';
  std::vector<std::string> names;
  std::size_t i = open + 1;
  // Keys may be bare or quoted; only strings that do not stand before a colon are labels. They come
  // in order of keys.
  while ((i = text.find_first_of("'\"", i)) != std::string_view::npos) {
    Quoted quoted = ReadQuoted(text, i);
    if (quoted.end == std::string_view::npos || names.size() >= kMostLabels) return {};
    i = quoted.end;
    const std::size_t next = text.find_first_not_of(" \t\r\n", i);
    const bool is_key = dictionary && next != std::string_view::npos && text[next] == ':';
    if (!is_key) names.push_back(std::move(quoted.text));
  }
  return names;
}

const std::vector<std::string>& CocoLabels() {
  static const std::vector<std::string> labels = {"person",        "bicycle",      "car",
                                                  "motorcycle",    "airplane",     "bus",
                                                  "train",         "truck",        "boat",
                                                  "traffic light", "fire hydrant", "stop sign",
                                                  "parking meter", "bench",        "bird",
                                                  "cat",           "dog",          "horse",
                                                  "sheep",         "cow",          "elephant",
                                                  "bear",          "zebra",        "giraffe",
                                                  "backpack",      "umbrella",     "handbag",
                                                  "tie",           "suitcase",     "frisbee",
                                                  "skis",          "snowboard",    "sports ball",
                                                  "kite",          "baseball bat", "baseball glove",
                                                  "skateboard",    "surfboard",    "tennis racket",
                                                  "bottle",        "wine glass",   "cup",
                                                  "fork",          "knife",        "spoon",
                                                  "bowl",          "banana",       "apple",
                                                  "sandwich",      "orange",       "broccoli",
                                                  "carrot",        "hot dog",      "pizza",
                                                  "donut",         "cake",         "chair",
                                                  "couch",         "potted plant", "bed",
                                                  "dining table",  "toilet",       "tv",
                                                  "laptop",        "mouse",        "remote",
                                                  "keyboard",      "cell phone",   "microwave",
                                                  "oven",          "toaster",      "sink",
                                                  "refrigerator",  "book",         "clock",
                                                  "vase",          "scissors",     "teddy bear",
                                                  "hair drier",    "toothbrush"};
  return labels;
}

}  // namespace deepslam::detect
