#include "deepslam/layouts/depth_scale.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace deepslam::layouts {
namespace {

using nlohmann::json;

// As letters alone, small ones: words are joined by "_", "-", blanks, or capitals.
constexpr std::array<std::string_view, 10> kNames = {"depthscale",
                                                     "depthscalefactor",
                                                     "depthfactor",
                                                     "depthmapfactor",
                                                     "depthunit",
                                                     "depthunits",
                                                     "depthunitsperm",
                                                     "depthunitspermeter",
                                                     "depthunitscalefactor",
                                                     "pngdepthscale"};
// Of raw depth, no camera has fewer than ten units to the metre.
constexpr double kMostMetres = 0.1;
constexpr double kMostUnitsPerM = 1e6;  // micrometres
// A camera's own scale is a 32-bit number near a whole one: 3999.999756.
constexpr double kSame = 1e-3;
// Objects within objects that are looked into.
constexpr int kDeepest = 3;

bool IsDepthScale(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) letters += static_cast<char>(std::tolower(byte));
  }
  return std::ranges::find(kNames, letters) != kNames.end();
}

struct Stated {
  std::string name;
  const json* value;
};

void Collect(const json& object, int depth, std::vector<Stated>& found) {
  for (const auto& [name, value] : object.items()) {
    if (IsDepthScale(name)) found.push_back({name, &value});
    if (value.is_object() && depth < kDeepest) Collect(value, depth + 1, found);
  }
}

Result<double> UnitsPerM(const Stated& stated,
                         const std::filesystem::path& file,
                         std::vector<std::string>& warnings) {
  const double value = stated.value->is_number() ? stated.value->get<double>() : 0;
  if (value >= 1 && value <= kMostUnitsPerM) return value;
  if (value >= 1 / kMostUnitsPerM && value <= kMostMetres) {
    warnings.push_back(
        fmt::format("{}: field '{}' is {}, taken for the metres of one unit: {:.6g} units a metre",
                    file.string(),
                    stated.name,
                    value,
                    1 / value));
    return 1 / value;
  }
  return InvalidInput(
      fmt::format("{}: field '{}' is {}, not a number in 1 .. {:.0f} (usual: 1000); it is the raw "
                  "depth of one metre",
                  file.string(),
                  stated.name,
                  stated.value->dump(-1, ' ', false, json::error_handler_t::replace),
                  kMostUnitsPerM));
}

}  // namespace

Result<std::optional<double>> FindDepthScale(std::string_view text,
                                             const std::filesystem::path& file,
                                             std::vector<std::string>& warnings) {
  const json root = json::parse(text, nullptr, false);
  std::vector<Stated> found;
  if (root.is_object()) Collect(root, 0, found);
  std::optional<double> units_per_m;
  for (const Stated& stated : found) {
    const Result<double> own = UnitsPerM(stated, file, warnings);
    if (!own) return own.error();
    if (units_per_m && std::abs(*own / *units_per_m - 1) > kSame) {
      return InvalidInput(
          fmt::format("{}: fields '{}' and '{}' state different raw depths of one metre, {} and "
                      "{}: remove the wrong one",
                      file.string(),
                      found.front().name,
                      stated.name,
                      *units_per_m,
                      *own));
    }
    if (!units_per_m) units_per_m = *own;
  }
  return units_per_m;
}

}  // namespace deepslam::layouts
