#include "deepslam/artifact/coco_losses.h"

#include <string_view>

#include <fmt/format.h>

namespace deepslam::artifact {
namespace {

// Both in the order of CocoFault.
constexpr std::array<std::string_view, kNumCocoFaults> kFaults = {
    "are no objects",
    "belong to no frame of the capture",
    "have a category without a name",
    "have a class that the class table does not know",
    "have no usable bbox inside the image",
    "have a score outside [0, 1]"};
constexpr std::array<std::string_view, kNumCocoFaults> kRemedies = {
    "an entry is an object with image_id, category_id and bbox",
    "image_id must be a frame index or name a colour file, by itself or by `images`",
    "`categories` must name each category_id, or each entry have a category_name; without "
    "`categories` the ids are COCO's, of which those of things in rooms are known",
    "add such names to the `labels` of a class in classes.yaml, or give the entries its classes",
    "bbox must be [x, y, width, height] in pixels, of an image as large as images[].width and "
    "height say",
    "score must lie in [0, 1]"};

}  // namespace

int CocoLosses::num_left_out() const {
  int sum = 0;
  for (const Kind& kind : left_out) sum += kind.num_entries;
  return sum;
}

std::string WhyNoneFits(const CocoLosses& losses) {
  std::string why;
  for (std::size_t n = 0; n < kNumCocoFaults; ++n) {
    const CocoLosses::Kind& kind = losses.left_out[n];
    if (kind.num_entries == 0) continue;
    why += fmt::format("{}{} (so {} of {}): {}",
                       why.empty() ? "" : "; ",
                       kind.first,
                       kind.num_entries,
                       losses.num_entries,
                       kRemedies[n]);
  }
  return why;
}

std::vector<std::string> LossesAbove(double share, const CocoLosses& losses) {
  std::vector<std::string> told;
  if (losses.num_left_out() > share * losses.num_entries) {
    std::string faults;
    for (std::size_t n = 0; n < kNumCocoFaults; ++n) {
      const int num_entries = losses.left_out[n].num_entries;
      if (num_entries == 0) continue;
      faults += fmt::format("{}{} {}", faults.empty() ? "" : ", ", num_entries, kFaults[n]);
    }
    told.push_back(fmt::format(
        "{} of {} entries are left out ({})", losses.num_left_out(), losses.num_entries, faults));
  }
  if (losses.num_unusable_masks > share * losses.num_masks) {
    told.push_back(fmt::format("{} of {} masks cannot be used, and the boxes stand in for them",
                               losses.num_unusable_masks,
                               losses.num_masks));
  }
  return told;
}

}  // namespace deepslam::artifact
