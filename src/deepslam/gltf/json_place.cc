#include "deepslam/gltf/json_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;

// Readers take JSON apart recursively: no honest scene is deeper.
constexpr int kMaxJsonDepth = 64;

const Json& In(const void* value) { return *static_cast<const Json*>(value); }

bool IsFinite(const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); }

bool IsNestedTooDeeply(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t n = 0; n < text.size(); ++n) {
    const char c = text[n];
    if (in_string) {
      if (c == '\\') ++n;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kMaxJsonDepth) return true;
  }
  return false;
}

}  // namespace

bool JsonPlace::IsObject() const { return exists() && In(value_).is_object(); }

JsonPlace JsonPlace::operator[](const std::string& member) const {
  std::string name = name_.empty() ? member : name_ + "." + member;
  const void* value = nullptr;
  if (IsObject()) {
    const auto found = In(value_).find(member);
    if (found != In(value_).end()) value = &*found;
  }
  return {value, std::move(name), *findings_};
}

std::vector<std::string> JsonPlace::Members() const {
  std::vector<std::string> members;
  if (!IsObject()) return members;
  for (const auto& entry : In(value_).items()) members.push_back(entry.key());
  return members;
}

std::size_t JsonPlace::Size() const {
  if (!exists()) return 0;
  const Json& list = In(value_);
  if (!list.is_array()) {
    Error("must be a list");
    return 0;
  }
  if (list.empty()) Breach("must be a list that is not empty");
  return list.size();
}

JsonPlace JsonPlace::At(std::size_t element) const {
  return {&In(value_)[element], name_ + "[" + std::to_string(element) + "]", *findings_};
}

std::uint64_t JsonPlace::Whole(std::uint64_t fallback) const {
  if (!exists()) return fallback;
  if (In(value_).is_number_unsigned()) return In(value_).get<std::uint64_t>();
  Error("must be a whole number that is not negative");
  return fallback;
}

double JsonPlace::Number(double fallback) const {
  if (!exists()) return fallback;
  if (IsFinite(In(value_))) return In(value_).get<double>();
  Error("must be a finite number");
  return fallback;
}

bool JsonPlace::Numbers(std::span<double> numbers) const {
  if (!exists()) return false;
  const Json& list = In(value_);
  if (!list.is_array() || list.size() != numbers.size() ||
      !std::all_of(list.begin(), list.end(), IsFinite)) {
    Error("must be a list of " + std::to_string(numbers.size()) + " finite numbers");
    return false;
  }
  std::ranges::transform(
      list, numbers.begin(), [](const Json& entry) { return entry.get<double>(); });
  return true;
}

int JsonPlace::Index(std::size_t size) const {
  // Stands for a field that is not there.
  constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t value = Whole(kNone);
  if (value == kNone) return -1;
  if (value < size && value < std::numeric_limits<int>::max()) return static_cast<int>(value);
  Error("is " + std::to_string(value) + " of " + std::to_string(size));
  return -1;
}

std::vector<int> JsonPlace::Indices(std::size_t size) const {
  std::vector<int> indices;
  const std::size_t count = Size();
  for (std::size_t n = 0; n < count; ++n) {
    const Json& entry = In(value_)[n];
    if (entry.is_number_unsigned() && entry.get<std::uint64_t>() < size) {
      indices.push_back(static_cast<int>(entry.get<std::uint64_t>()));
    } else {
      Error("names what is not there");
    }
  }
  return indices;
}

std::string JsonPlace::Text() const {
  return exists() && In(value_).is_string() ? In(value_).get<std::string>() : std::string();
}

std::optional<std::int64_t> JsonPlace::MaybeWhole() const {
  if (!exists() || !In(value_).is_number_integer()) return std::nullopt;
  return In(value_).get<std::int64_t>();
}

std::optional<double> JsonPlace::MaybeNumber() const {
  if (!exists() || !In(value_).is_number()) return std::nullopt;
  return In(value_).get<double>();
}

bool JsonPlace::IsTrue() const { return exists() && In(value_) == Json(true); }

std::string JsonPlace::Dump() const { return exists() ? In(value_).dump(-1, ' ', true) : ""; }

std::optional<GltfJson> GltfJson::Parse(std::string_view text, Findings& findings) {
  if (IsNestedTooDeeply(text)) {
    findings.Error("JSON", "is nested deeper than " + std::to_string(kMaxJsonDepth));
    return std::nullopt;
  }
  auto document =
      std::make_shared<const Json>(Json::parse(text.begin(), text.end(), nullptr, false));
  if (document->is_discarded() || !document->is_object()) {
    findings.Error("JSON", "is damaged or cut off, or no object");
    return std::nullopt;
  }
  return GltfJson(std::move(document), findings);
}

}  // namespace deepslam::gltf
