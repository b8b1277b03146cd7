#include "deepslam/artifact/json_visitor.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deepslam::artifact {

JsonObject& JsonVisitor::members() { return members_ ? *members_ : members_.emplace(); }

JsonValue JsonVisitor::Take() && {
  return members_ ? JsonValue(*std::move(members_)) : std::move(value_);
}

void JsonVisitor::WriteOnly(std::string_view name, JsonValue value) {
  if (writing()) members().emplace(name, std::move(value));
}

void JsonVisitor::Numbers(std::span<double> numbers) {
  if (writing()) value_ = JsonArray(numbers.begin(), numbers.end());
  if (reading())
    std::ranges::copy(node_->Numbers(static_cast<int>(numbers.size())), numbers.begin());
}

bool JsonVisitor::Null(bool is_none) { return reading() ? !node_->exists() : is_none; }

void JsonVisitor::Value(double& value, Range range) {
  if (writing()) value_ = value;
  if (reading()) value = node_->Number(range.min, range.max);
}

void JsonVisitor::Value(int& value, Range range) {
  if (writing()) value_ = value;
  if (reading()) value = node_->Int(static_cast<int>(range.min), static_cast<int>(range.max));
}

void JsonVisitor::Value(bool& value) {
  if (writing()) value_ = value;
  if (reading()) value = node_->Bool();
}

void JsonVisitor::Value(std::string& value) {
  if (writing()) value_ = value;
  if (reading()) value = node_->String();
}

int JsonVisitor::IndexOfName(std::span<const std::string_view> names) const {
  const std::string text = node_->String();
  const auto found = std::ranges::find(names, std::string_view(text));
  if (found != names.end()) return static_cast<int>(found - names.begin());
  node_->Fail(fmt::format("is \"{}\", must be one of: {}", text, fmt::join(names, ", ")));
  return 0;
}

void JsonVisitor::Fail(std::string_view name, std::string_view what) const {
  if (!reading()) return;
  (name.empty() ? *node_ : node_->Maybe(name)).Fail(what);
}

void Describe(JsonVisitor& visitor, float& value, Range range) {
  // A float's own shortest form would read back as another double; the double of the float reads
  // back as the float.
  double wide = static_cast<double>(value);
  visitor.Value(wide, range);
  if (visitor.reading()) value = static_cast<float>(wide);
}

void Describe(JsonVisitor& visitor, std::uint8_t& value) {
  int wide = value;
  visitor.Value(wide, Range{0, 255});
  if (visitor.reading()) value = static_cast<std::uint8_t>(wide);
}

}  // namespace deepslam::artifact
