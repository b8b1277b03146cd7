#include "deepslam/artifact/json_reader.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace deepslam::artifact {
namespace {

std::string Join(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

}  // namespace

JsonNode JsonNode::Maybe(std::string_view key) const {
  const JsonObject* object = value_ == nullptr ? nullptr : value_->As<JsonObject>();
  if (object == nullptr) return {reader_, nullptr, Join(path_, key)};
  const auto it = object->find(key);
  return {reader_, it == object->end() ? nullptr : &it->second, Join(path_, key)};
}

JsonNode JsonNode::operator[](std::string_view key) const {
  if (value_ != nullptr && !is_object()) Fail("must be an object");
  JsonNode member = Maybe(key);
  if (member.value_ == nullptr) member.Fail("is missing");
  return member;
}

double JsonNode::Number() const {
  if (value_ != nullptr) {
    if (const auto* number = value_->As<double>()) return *number;
    if (const auto* integer = value_->As<std::int64_t>()) return static_cast<double>(*integer);
  }
  Fail("must be a number");
  return 0;
}

double JsonNode::Number(double min, double max) const {
  const double value = Number();
  if (value >= min && value <= max) return value;
  Fail(fmt::format("is {}, must lie in [{}, {}]", value, min, max));
  return min;
}

int JsonNode::Int(int min, int max) const {
  const double value = Number();
  if (value == std::floor(value) && value >= min && value <= max) return static_cast<int>(value);
  Fail(fmt::format("is {}, must be an integer in [{}, {}]", value, min, max));
  return min;
}

bool JsonNode::Bool() const {
  if (value_ != nullptr) {
    if (const auto* flag = value_->As<bool>()) return *flag;
  }
  Fail("must be true or false");
  return false;
}

std::string JsonNode::String() const {
  if (value_ != nullptr) {
    if (const auto* string = value_->As<std::string>()) return *string;
  }
  Fail("must be a string");
  return {};
}

std::vector<JsonNode> JsonNode::Items(int count) const {
  std::vector<JsonNode> items;
  const JsonArray* array = value_ == nullptr ? nullptr : value_->As<JsonArray>();
  if (array == nullptr) {
    Fail("must be an array");
  } else if (count >= 0 && array->size() != static_cast<std::size_t>(count)) {
    Fail(fmt::format("has {} elements, must have {}", array->size(), count));
    array = nullptr;
  }
  const std::size_t size = array != nullptr ? array->size() : 0;
  items.reserve(size);
  for (std::size_t i = 0; i < size; ++i) {
    items.push_back(JsonNode(reader_, &(*array)[i], fmt::format("{}[{}]", path_, i)));
  }
  for (int i = static_cast<int>(size); i < count; ++i)
    items.push_back(JsonNode(reader_, nullptr, path_));
  return items;
}

std::vector<double> JsonNode::Numbers(int count) const {
  std::vector<double> numbers;
  for (const JsonNode& item : Items(count)) numbers.push_back(item.Number());
  return numbers;
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::Members() const {
  std::vector<std::pair<std::string, JsonNode>> members;
  const JsonObject* object = value_ == nullptr ? nullptr : value_->As<JsonObject>();
  if (object == nullptr) {
    Fail("must be an object");
    return members;
  }
  for (const auto& [key, value] : *object) {
    members.emplace_back(key, JsonNode(reader_, &value, Join(path_, key)));
  }
  return members;
}

void JsonNode::Fail(std::string_view what) const { reader_->Fail(path_, what); }

JsonReader::JsonReader(TextSource text,
                       std::string_view name,
                       std::string_view format,
                       int version,
                       std::vector<JsonTable> tables)
    : JsonReader(std::move(text), name, JsonFormat{format, version}, std::move(tables)) {}

JsonReader::JsonReader(TextSource text,
                       std::string_view name,
                       const JsonFormat& format,
                       std::vector<JsonTable> tables)
    : name_(name) {
  std::vector<JsonStream> streams;
  for (const JsonTable& table : tables) {
    streams.push_back({table.key, [&](std::size_t first, std::span<const JsonValue> values) {
                         if (!ok()) return;
                         std::vector<JsonNode> rows;
                         for (std::size_t i = 0; i < values.size(); ++i) {
                           rows.push_back(JsonNode(
                               this, &values[i], fmt::format("{}[{}]", table.key, first + i)));
                         }
                         table.read(rows);
                       }});
  }
  Result<JsonValue> parsed = ParseJson(std::move(text), name, streams);
  if (!parsed.ok()) {
    fault_ = parsed.error().message;
    return;
  }
  document_ = std::move(parsed).value();
  // Rows come before the version, which says more than what is wrong in them.
  const std::string fault_of_rows = std::exchange(fault_, {});
  if (!format.name.empty()) CheckFormat(format);
  if (ok()) fault_ = fault_of_rows;
  for (const JsonTable& table : tables) {
    if (!table.must_be_there) continue;
    const JsonNode rows = root()[table.key];
    if (rows.value_ != nullptr && !rows.is_array()) rows.Fail("must be an array");
  }
}

void JsonReader::CheckFormat(const JsonFormat& format) {
  const JsonNode document = root();
  const JsonNode found_format = document.Maybe("format");
  if (!found_format.is_string() || found_format.String() != format.name) {
    Fail("format",
         fmt::format("is not \"{}\": this is no file of deepslam, or one of another kind",
                     format.name));
    return;
  }
  const int found = document["version"].Int(1, 1000000);
  const bool is_read = found == format.version ||
                       (format.oldest > 0 && found >= format.oldest && found < format.version);
  if (ok() && !is_read) {
    Fail("version",
         fmt::format("is {}, this program reads {}: {}",
                     found,
                     format.version,
                     found > format.version ? "use a newer deepslam"
                                            : "make the file again with this deepslam"));
  }
}

void JsonReader::Fail(std::string_view path, std::string_view what) {
  if (fault_.empty())
    fault_ = fmt::format("{}: {} {}", name_, path.empty() ? "document" : path, what);
}

JsonObject NewDocument(std::string_view format, int version) {
  JsonObject document;
  document.emplace("format", format);
  document.emplace("version", version);
  return document;
}

}  // namespace deepslam::artifact
