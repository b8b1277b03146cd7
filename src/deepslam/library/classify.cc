#include "deepslam/library/classify.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

namespace deepslam::library {
namespace {

struct Rule {
  std::string_view class_name;
  std::string_view names;   // any of these words in the name ...
  std::string_view except;  // ... and none of these
  double min_height_m;
  double max_height_m;
  double min_longest_m;  // of the footprint
  double max_longest_m;
  bool has_back = false;
};

// In order: a "bedside table" is a cabinet before it is a table. Heights and lengths keep toys, sun
// loungers and wall units out.
constexpr std::array<Rule, 6> kRules = {
    {{"cabinet",
      "cabinet wardrobe cupboard dresser drawers nightstand bedside chest sideboard tv-stand "
      "locker",
      "freezer glass upper corner sink locked",
      0.35,
      2.6,
      0.3,
      2.8},
     {"shelf", "bookcase shelves bookshelf shelving", "upper wall", 0.5, 2.6, 0.3, 3.1},
     {"sofa", "sofa couch", "opened bed", 0.5, 1.2, 1.0, 3.6, true},
     {"bed", "bed", "baby bunk mezzanine air", 0.3, 1.5, 1.5, 2.6, true},
     {"chair",
      "chair armchair stool seat",
      "wheelchair baby high beach deck relax ottoman leon",
      0.6,
      1.3,
      0.25,
      1.15,
      true},
     {"table",
      "table desk",
      "lamp fan tennis football pool changing dressing bat children bell",
      0.3,
      1.1,
      0.45,
      3.0}}};

// Lower-case words of a text, and its pairs of neighbouring words ("tv-stand").
std::set<std::string, std::less<>> Words(std::string_view text) {
  std::set<std::string, std::less<>> words;
  std::string word;
  std::string previous;
  const auto end_word = [&] {
    if (word.empty()) return;
    if (!previous.empty()) words.insert(previous + "-" + word);
    words.insert(word);
    previous = std::exchange(word, {});
  };
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      word.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
    } else {
      end_word();
    }
  }
  end_word();
  return words;
}

bool AnyOf(std::string_view list, const std::set<std::string, std::less<>>& words) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (words.contains(list.substr(0, end))) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

}  // namespace

std::optional<std::string> ClassOfItem(const CatalogueItem& item) {
  // Hung on a wall or standing on other furniture.
  constexpr double kMaxElevation_m = 0.05;
  if (item.door_or_window || item.elevation_m > kMaxElevation_m) return std::nullopt;
  const std::set<std::string, std::less<>> words = Words(item.name);
  const double longest_m = std::max(item.width_m, item.depth_m);
  for (const Rule& rule : kRules) {
    if (!AnyOf(rule.names, words) || AnyOf(rule.except, words)) continue;
    const bool height_fits =
        item.height_m >= rule.min_height_m && item.height_m <= rule.max_height_m;
    const bool length_fits = longest_m >= rule.min_longest_m && longest_m <= rule.max_longest_m;
    if (height_fits && length_fits) return std::string(rule.class_name);
    return std::nullopt;
  }
  return std::nullopt;
}

bool HasBack(std::string_view class_name) {
  return std::any_of(kRules.begin(), kRules.end(), [class_name](const Rule& rule) {
    return rule.class_name == class_name && rule.has_back;
  });
}

}  // namespace deepslam::library
