// Whether the map of a run can be used as it is.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace deepslam {

// Good: usable as it is. Doubtful: look at the reasons. Bad: not to be used.
enum class Verdict { kGood, kDoubtful, kBad };

inline constexpr std::array<std::string_view, 3> kVerdictNames = {"good", "doubtful", "bad"};
[[nodiscard]] constexpr std::string_view NameOf(Verdict verdict) {
  return kVerdictNames[static_cast<std::size_t>(verdict)];
}

struct RunVerdict {
  Verdict verdict = Verdict::kGood;
  std::vector<std::string> reasons;  // sentences for people
};

}  // namespace deepslam
