#include "deepslam/library/catalogue.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

namespace deepslam::library {
namespace {

constexpr double kMetresPerCentimetre = 0.01;  // catalogues of Sweet Home 3D are in centimetres
using Fields = std::map<std::string, std::string, std::less<>>;

void AppendUtf8(std::uint32_t code, std::string& text) {
  if (code < 0x80) {
    text.push_back(static_cast<char>(code));
  } else if (code < 0x800) {
    text.push_back(static_cast<char>(0xC0U | (code >> 6U)));
    text.push_back(static_cast<char>(0x80U | (code & 0x3FU)));
  } else {
    text.push_back(static_cast<char>(0xE0U | (code >> 12U)));
    text.push_back(static_cast<char>(0x80U | ((code >> 6U) & 0x3FU)));
    text.push_back(static_cast<char>(0x80U | (code & 0x3FU)));
  }
}

std::optional<std::uint32_t> HexCode(std::string_view digits) {
  std::uint32_t code = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
  if (digits.size() != 4 || error != std::errc() || end != digits.data() + 4) return std::nullopt;
  return code;
}

// Latin-1 with the escapes of Java properties -> UTF-8 without control characters.
std::string Unescaped(std::string_view latin1) {
  std::string text;
  for (std::size_t n = 0; n < latin1.size(); ++n) {
    auto code = static_cast<std::uint32_t>(static_cast<unsigned char>(latin1[n]));
    if (code == '\\' && n + 1 < latin1.size()) {
      ++n;
      code = static_cast<std::uint32_t>(static_cast<unsigned char>(latin1[n]));
      if (code == 'u') {
        const std::optional<std::uint32_t> escaped = HexCode(latin1.substr(n + 1, 4));
        if (escaped) n += 4;
        // Surrogates would need their partner; catalogues hold none, and half a character is worse
        // than '?'.
        code = escaped && (*escaped < 0xD800 || *escaped > 0xDFFF) ? *escaped : '?';
      } else if (code == 't' || code == 'n' || code == 'r' || code == 'f') {
        code = ' ';
      }
    }
    AppendUtf8(code < 0x20 || code == 0x7F ? ' ' : code, text);
  }
  return text;
}

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\f";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

// Lines of the file, with those that end in a backslash joined with the next one.
std::vector<std::string> LogicalLines(std::string_view bytes) {
  std::vector<std::string> lines;
  bool joined = false;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    std::string_view line = Trimmed(bytes.substr(0, end));
    bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
    const bool goes_on = line.ends_with('\\') && !line.ends_with("\\\\");
    if (goes_on) line.remove_suffix(1);
    if (joined) {
      lines.back() += line;
    } else {
      lines.emplace_back(line);
    }
    joined = goes_on;
  }
  return lines;
}

std::optional<double> Number(std::string_view text) {
  text = Trimmed(text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string Text(const Fields& fields, std::string_view key) {
  const auto it = fields.find(key);
  return it == fields.end() ? std::string() : Unescaped(it->second);
}

// A length in centimetres as metres; sets the item's fault when it is missing or no furniture has
// it.
double Length_m(const Fields& fields, std::string_view key, CatalogueItem& item) {
  constexpr double kMax_cm = 5000;  // 50 m: larger numbers are in another unit
  const auto it = fields.find(key);
  const std::optional<double> value = it == fields.end() ? std::nullopt : Number(it->second);
  if (!value || !(*value > 0) || *value > kMax_cm) {
    item.fault = std::string(key) + " is missing or no length: '" +
                 (it == fields.end() ? std::string() : it->second) + "'";
    return 0;
  }
  return *value * kMetresPerCentimetre;
}

std::optional<Eigen::Matrix3d> Rotation(std::string_view text) {
  Eigen::Matrix3d rotation;
  for (int n = 0; n < 9; ++n) {
    text = Trimmed(text);
    const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
    const std::optional<double> value = Number(text.substr(0, end));
    if (!value) return std::nullopt;
    rotation(n / 3, n % 3) = *value;
    text.remove_prefix(end);
  }
  constexpr double kTolerance = 1e-2;  // catalogues round to three digits
  const bool orthogonal =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < kTolerance;
  return Trimmed(text).empty() && orthogonal ? std::optional(rotation) : std::nullopt;
}

CatalogueItem ItemOf(const Fields& fields) {
  CatalogueItem item;
  item.id = Text(fields, "id");
  item.name = Text(fields, "name");
  item.creator = Text(fields, "creator");
  item.model = Text(fields, "model");
  while (item.model.starts_with('/')) item.model.erase(0, 1);
  item.width_m = Length_m(fields, "width", item);
  item.depth_m = Length_m(fields, "depth", item);
  item.height_m = Length_m(fields, "height", item);
  item.elevation_m = Number(Text(fields, "elevation")).value_or(0) * kMetresPerCentimetre;
  item.door_or_window = Text(fields, "doorOrWindow") == "true";
  if (const auto it = fields.find("modelRotation"); it != fields.end()) {
    const std::optional<Eigen::Matrix3d> rotation = Rotation(it->second);
    if (rotation) item.rotation = *rotation;
    if (!rotation) item.fault = "modelRotation is no rotation: '" + it->second + "'";
  }
  if (item.model.empty()) item.fault = "model is missing";
  if (item.id.empty()) item.fault = "id is missing";
  return item;
}

}  // namespace

Result<Catalogue> ParseCatalogue(std::string_view latin1) {
  Catalogue catalogue;
  std::map<int, Fields> items;
  for (const std::string& line : LogicalLines(latin1)) {
    const std::size_t equals = line.find('=');
    if (line.starts_with('#') || line.starts_with('!') || equals == std::string::npos) continue;
    const std::string_view key = Trimmed(std::string_view(line).substr(0, equals));
    const std::string_view value = Trimmed(std::string_view(line).substr(equals + 1));
    const std::size_t hash = key.find('#');
    if (hash == std::string_view::npos) {
      if (key == "name") catalogue.name = Unescaped(value);
      if (key == "license") catalogue.licence = Unescaped(value);
      continue;
    }
    int number = 0;
    const auto [end, error] =
        std::from_chars(key.data() + hash + 1, key.data() + key.size(), number);
    if (error != std::errc() || end != key.data() + key.size()) continue;
    items[number].emplace(std::string(key.substr(0, hash)), std::string(value));
  }
  for (const auto& [number, fields] : items) catalogue.items.push_back(ItemOf(fields));
  if (catalogue.items.empty())
    return InvalidInput("catalogue lists no furniture (no 'id#N=' line)");
  return catalogue;
}

}  // namespace deepslam::library
