#include "deepslam/library/classify.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace deepslam::library {
namespace {

struct Rule {
  std::string_view class_name;
  std::vector<std::string_view> words;   // any of these in the name ...
  std::vector<std::string_view> except;  // ... and none of these
  double min_height_m;
  double max_height_m;
  double min_longest_m;  // of the footprint
  double max_longest_m;
};

// In order: a "bedside table" is a cabinet before it is a table. Heights and lengths keep toys, sun
// loungers and wall units out.
const std::vector<Rule>& Rules() {
  static const std::vector<Rule> rules = {
      {"cabinet",
       {"cabinet",
        "wardrobe",
        "cupboard",
        "dresser",
        "drawers",
        "nightstand",
        "bedside",
        "chest",
        "sideboard",
        "commode",
        "buffet",
        "stand",
        "locker"},
       {"freezer", "glass", "tv", "upper", "corner", "sink", "locked"},
       0.35,
       2.6,
       0.3,
       2.8},
      {"cabinet", {"tv"}, {"unit", "set", "screen", "flat"}, 0.35, 1.0, 0.6, 2.5},
      {"shelf",
       {"bookcase", "shelves", "bookshelf", "shelving"},
       {"upper", "wall"},
       0.5,
       2.6,
       0.3,
       3.1},
      {"sofa", {"sofa", "couch"}, {"opened", "bed"}, 0.5, 1.2, 1.0, 3.6},
      {"bed", {"bed"}, {"baby", "bunk", "mezzanine", "sofa", "air"}, 0.3, 1.5, 1.5, 2.6},
      {"chair",
       {"chair", "armchair", "stool", "seat"},
       {"wheelchair", "baby", "high", "beach", "deck", "relax", "cushions", "ottoman", "leon"},
       0.6,
       1.3,
       0.25,
       1.15},
      {"table",
       {"table", "desk"},
       {"lamp",
        "fan",
        "tennis",
        "football",
        "pool",
        "changing",
        "dressing",
        "bat",
        "children",
        "bell"},
       0.3,
       1.1,
       0.45,
       3.0},
  };
  return rules;
}

std::set<std::string, std::less<>> Words(std::string_view name) {
  std::set<std::string, std::less<>> words;
  std::string word;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      word.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
    } else if (!word.empty()) {
      words.insert(std::exchange(word, {}));
    }
  }
  if (!word.empty()) words.insert(word);
  return words;
}

}  // namespace

std::optional<std::string> ClassOfItem(const CatalogueItem& item) {
  // Hung on a wall or standing on other furniture.
  constexpr double kMaxElevation_m = 0.05;
  if (item.door_or_window || item.elevation_m > kMaxElevation_m) return std::nullopt;
  const std::set<std::string, std::less<>> words = Words(item.name);
  const auto named = [&](std::string_view word) { return words.contains(word); };
  const double longest_m = std::max(item.width_m, item.depth_m);
  for (const Rule& rule : Rules()) {
    if (std::none_of(rule.words.begin(), rule.words.end(), named)) continue;
    if (std::any_of(rule.except.begin(), rule.except.end(), named)) continue;
    const bool height_fits =
        item.height_m >= rule.min_height_m && item.height_m <= rule.max_height_m;
    const bool length_fits = longest_m >= rule.min_longest_m && longest_m <= rule.max_longest_m;
    if (height_fits && length_fits) return std::string(rule.class_name);
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace deepslam::library
