// Fields named once, for writing and for reading: beside every codec stands, for each struct,
//   void Describe(JsonVisitor& visitor, TrackMember& member) {
//     visitor.Field("detection", member.detection);
//     visitor.Field("dissimilarity_m", member.dissimilarity_m, Range{0, 10});
//   }
// A visitor that writes takes the values of the fields and changes none. One that reads gives them
// theirs; what is missing, of the wrong type or out of range is a fault of its reader (see
// json_reader.h), which keeps the first with its place. Fields are looked at in their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"

namespace deepslam::artifact {

// Counts and ids beyond are damage; no capture has as many items.
inline constexpr int kMaxId = 100'000'000;
inline constexpr Range kAnyCount{0, kMaxId};
inline constexpr Range kAnyNumber{-std::numeric_limits<double>::infinity(),
                                  std::numeric_limits<double>::infinity()};  // that is finite

class JsonVisitor;

struct ByDescribe {
  template <typename T>
  void operator()(JsonVisitor& visitor, T& value) const {
    Describe(visitor, value);
  }
};

// One value of a document on its way out of the program or into it.
class JsonVisitor {
 public:
  JsonVisitor() = default;                                                    // writes
  explicit JsonVisitor(const JsonNode& node) : node_(&node) {}                // reads what is there
  explicit JsonVisitor(std::vector<JsonTable>& tables) : tables_(&tables) {}  // see Table

  [[nodiscard]] bool reading() const { return node_ != nullptr; }
  [[nodiscard]] bool writing() const { return node_ == nullptr && tables_ == nullptr; }
  // What a visitor that writes was told.
  [[nodiscard]] JsonValue Take() &&;

  // A member of an object, which has to be there; `limits` as Describe of its type takes them.
  template <typename T, typename... Limits>
  void Field(std::string_view name, T& value, const Limits&... limits);
  // A member that files may lack or have null: the value then stays as it is. Written where
  // `is_given`. Tells whether the file has it.
  template <typename T, typename... Limits>
  bool Maybe(std::string_view name, T& value, bool is_given = true, const Limits&... limits);
  // A member for other programs.
  void WriteOnly(std::string_view name, JsonValue value);
  // A member of a document that grows with the length of a capture. It is written row by row, and
  // read so while the text is parsed, before all other members. `rows` has to stay where it is;
  // `describe` takes the place of Describe of a row.
  template <typename T, typename DescribeRow = ByDescribe>
  void Table(std::string_view name, std::vector<T>& rows, DescribeRow describe = {});

  // Values that are no object: an array of values told apart by their place; numbers; null where
  // `is_none` (it tells whether it is); a name of an enumeration's values, in their order.
  template <typename... Values>
  void Columns(Values&... values);
  void Numbers(std::span<double> numbers);
  [[nodiscard]] bool Null(bool is_none);
  template <typename Enum>
  void Choice(Enum& value, std::span<const std::string_view> names);
  void Value(double& value, Range range);
  void Value(int& value, Range range);
  void Value(bool& value);
  void Value(std::string& value);
  template <typename T, typename... Limits>
  void List(std::vector<T>& values, const Limits&... limits);
  template <typename T>
  void Map(std::map<std::string, T>& values);

  // A fault of what is read, in a member or, with an empty name, in the value itself.
  void Fail(std::string_view name, std::string_view what) const;

 private:
  [[nodiscard]] int IndexOfName(std::span<const std::string_view> names) const;
  JsonObject& members();

  const JsonNode* node_ = nullptr;
  std::vector<JsonTable>* tables_ = nullptr;
  JsonValue value_;
  std::optional<JsonObject> members_;
};

inline void Describe(JsonVisitor& visitor, double& value, Range range = kAnyNumber) {
  visitor.Value(value, range);
}
inline void Describe(JsonVisitor& visitor, int& value, Range range = kAnyCount) {
  visitor.Value(value, range);
}
inline void Describe(JsonVisitor& visitor, bool& value) { visitor.Value(value); }
inline void Describe(JsonVisitor& visitor, std::string& value) { visitor.Value(value); }
void Describe(JsonVisitor& visitor, float& value, Range range = kAnyNumber);
void Describe(JsonVisitor& visitor, std::uint8_t& value);
// null: none.
template <typename Tag>
void Describe(JsonVisitor& visitor, StrongId<Tag>& id) {
  if (!visitor.Null(!id.valid())) visitor.Value(id.value, kAnyCount);
}
template <typename T>
void Describe(JsonVisitor& visitor, std::optional<T>& value) {
  if (visitor.Null(!value.has_value())) return;
  if (visitor.reading()) value.emplace();
  Describe(visitor, *value);
}
template <typename T, typename... Limits>
void Describe(JsonVisitor& visitor, std::vector<T>& values, const Limits&... limits) {
  visitor.List(values, limits...);
}
template <typename T>
void Describe(JsonVisitor& visitor, std::map<std::string, T>& values) {
  visitor.Map(values);
}

// As Describe has it: a value's form, and the value that stands in a place of a document.
template <typename T, typename... Limits>
[[nodiscard]] JsonValue ToJson(const T& value, const Limits&... limits) {
  JsonVisitor visitor;
  Describe(visitor, const_cast<T&>(value), limits...);  // a visitor that writes changes nothing
  return std::move(visitor).Take();
}
template <typename T, typename... Limits>
[[nodiscard]] T FromJson(const JsonNode& node, const Limits&... limits) {
  T value{};
  JsonVisitor visitor(node);
  Describe(visitor, value, limits...);
  return value;
}

// A whole file, as Describe of T or `describe` has it; `name` is what messages call it.
template <typename T, typename DescribeT = ByDescribe>
[[nodiscard]] Result<std::string> EncodeDocument(const JsonFormat& format,
                                                 const T& value,
                                                 std::string_view name,
                                                 DescribeT describe = {}) {
  JsonVisitor visitor;
  visitor.WriteOnly("format", format.name);
  visitor.WriteOnly("version", format.version);
  describe(visitor, const_cast<T&>(value));  // a visitor that writes changes nothing
  return DumpJson(std::move(visitor).Take(), name);
}
template <typename T, typename DescribeT = ByDescribe>
[[nodiscard]] Result<T> DecodeDocument(const JsonFormat& format,
                                       TextSource text,
                                       std::string_view name,
                                       DescribeT describe = {}) {
  T value{};
  std::vector<JsonTable> tables;
  JsonVisitor for_tables(tables);
  describe(for_tables, value);
  JsonReader reader(std::move(text), name, format, std::move(tables));
  const JsonNode root = reader.root();
  JsonVisitor visitor(root);
  describe(visitor, value);
  return reader.Finish(std::move(value));
}

template <typename T, typename... Limits>
void JsonVisitor::Field(std::string_view name, T& value, const Limits&... limits) {
  if (writing()) members().emplace(name, ToJson(value, limits...));
  if (reading()) {
    const JsonNode member = (*node_)[name];
    JsonVisitor visitor(member);
    Describe(visitor, value, limits...);
  }
}

template <typename T, typename... Limits>
bool JsonVisitor::Maybe(std::string_view name, T& value, bool is_given, const Limits&... limits) {
  if (!reading()) {
    if (writing()) members();  // an object, be it empty
    if (writing() && is_given) members().emplace(name, ToJson(value, limits...));
    return is_given;
  }
  const JsonNode member = node_->Maybe(name);
  if (!member.exists()) return false;
  JsonVisitor visitor(member);
  Describe(visitor, value, limits...);
  return true;
}

template <typename T, typename DescribeRow>
void JsonVisitor::Table(std::string_view name, std::vector<T>& rows, DescribeRow describe) {
  if (tables_ != nullptr) {
    const auto read = [&rows, describe](std::span<const JsonNode> nodes) {
      for (const JsonNode& node : nodes) {
        JsonVisitor visitor(node);
        describe(visitor, rows.emplace_back());
      }
    };
    tables_->push_back({name, read});
  }
  if (!writing()) return;
  const auto row = [&rows, describe](std::size_t index) {
    JsonVisitor visitor;
    describe(visitor, rows[index]);
    return std::move(visitor).Take();
  };
  members().emplace(name, JsonRows{rows.size(), row});
}

template <typename... Values>
void JsonVisitor::Columns(Values&... values) {
  if (writing()) value_ = JsonArray{ToJson(values)...};
  if (!reading()) return;
  const std::vector<JsonNode> nodes = node_->Items(sizeof...(Values));
  std::size_t column = 0;
  const auto read = [&](auto& value) {
    JsonVisitor visitor(nodes[column++]);
    Describe(visitor, value);
  };
  (read(values), ...);
}

template <typename Enum>
void JsonVisitor::Choice(Enum& value, std::span<const std::string_view> names) {
  if (writing()) value_ = names[static_cast<std::size_t>(value)];
  if (reading()) value = static_cast<Enum>(IndexOfName(names));
}

template <typename T, typename... Limits>
void JsonVisitor::List(std::vector<T>& values, const Limits&... limits) {
  if (writing()) {
    JsonArray elements;
    for (const T& value : values) elements.push_back(ToJson(value, limits...));
    value_ = std::move(elements);
  }
  if (!reading()) return;
  for (const JsonNode& node : node_->Items()) values.push_back(FromJson<T>(node, limits...));
}

template <typename T>
void JsonVisitor::Map(std::map<std::string, T>& values) {
  if (writing()) {
    for (const auto& [name, value] : values) members().emplace(name, ToJson(value));
    if (values.empty()) value_ = JsonObject();
  }
  if (!reading()) return;
  for (const auto& [name, node] : node_->Members()) values[name] = FromJson<T>(node);
}

}  // namespace deepslam::artifact
