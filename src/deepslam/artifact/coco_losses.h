// What of a user's detections could not be used, and how it is told.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace deepslam::artifact {

// Why an entry is left out; each has one reason.
enum class CocoFault {
  kNoObject,
  kUnknownImage,
  kNamelessCategory,
  kUnknownClass,
  kUnusableBox,
  kUnusableScore
};
inline constexpr std::size_t kNumCocoFaults = 6;  // enumerators of CocoFault

struct CocoLosses {
  struct Kind {
    int num_entries = 0;
    std::string first;  // one of them, with its place
  };

  int num_entries = 0;  // of the file
  std::array<Kind, kNumCocoFaults> left_out;
  int num_masks = 0;           // of the entries in use; polygons are none
  int num_unusable_masks = 0;  // their boxes stay in force

  [[nodiscard]] Kind& Of(CocoFault fault) { return left_out[static_cast<std::size_t>(fault)]; }
  [[nodiscard]] const Kind& Of(CocoFault fault) const {
    return left_out[static_cast<std::size_t>(fault)];
  }
  [[nodiscard]] int num_left_out() const;
};

// Of a file none of whose entries is in use: for each reason the first, how many, and the remedy.
[[nodiscard]] std::string WhyNoneFits(const CocoLosses& losses);

// What is lost, a sentence on entries and one on masks, each where more than `share` of them are.
[[nodiscard]] std::vector<std::string> LossesAbove(double share, const CocoLosses& losses);

}  // namespace deepslam::artifact
