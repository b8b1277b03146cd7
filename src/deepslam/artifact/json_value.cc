#include "deepslam/artifact/json_value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace deepslam::artifact {
namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kLineWidth = 100;
constexpr std::size_t kElementsAtOnce = 64;  // of a stream; enough to work on side by side

// Takes a text's values as the parser finds them.
class Builder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Builder(std::span<const JsonStream> streams) : streams_(streams) {}

  bool null() override { return Add({}); }
  bool boolean(bool value) override { return Add(value); }
  bool number_integer(std::int64_t value) override { return Add(value); }
  bool number_unsigned(std::uint64_t value) override {
    if (value > static_cast<std::uint64_t>(INT64_MAX)) return Add(static_cast<double>(value));
    return Add(static_cast<std::int64_t>(value));
  }
  bool number_float(double value, const std::string& /*text*/) override { return Add(value); }
  bool string(std::string& value) override { return Add(std::move(value)); }
  bool binary(binary_t& /*value*/) override { return false; }  // none in text
  bool start_object(std::size_t /*size*/) override { return Open(true); }
  bool start_array(std::size_t /*size*/) override { return Open(false); }
  bool key(std::string& value) override {
    open_.back().key = std::move(value);
    return true;
  }
  bool end_object() override {
    JsonValue value(std::move(open_.back().object));
    open_.pop_back();
    return Add(std::move(value));
  }
  bool end_array() override {
    if (open_.back().stream != nullptr) Flush(open_.back());
    JsonValue value(std::move(open_.back().array));
    open_.pop_back();
    return Add(std::move(value));
  }
  bool parse_error(std::size_t /*position*/,
                   const std::string& /*token*/,
                   const nlohmann::json::exception& error) override {
    fault_ = error.what();
    return false;
  }

  [[nodiscard]] bool too_deep() const { return too_deep_; }
  [[nodiscard]] std::string_view twice() const { return twice_; }    // a streamed array's key
  [[nodiscard]] const std::string& fault() const { return fault_; }  // empty where there is none
  [[nodiscard]] JsonValue Take() { return std::move(root_); }

 private:
  struct OpenValue {
    bool is_object = false;
    JsonArray array;
    JsonObject object;
    std::string key;                     // of the member that comes next
    const JsonStream* stream = nullptr;  // that takes the array's elements
    std::size_t num_taken = 0;
  };

  bool Open(bool is_object) {
    too_deep_ = open_.size() > kMaxDepth;
    const JsonStream* const stream = is_object || open_.size() != 1 ? nullptr : StreamOf(open_[0]);
    if (stream != nullptr && open_[0].object.contains(stream->key)) {
      twice_ = stream->key;
      return false;
    }
    OpenValue& opened = open_.emplace_back();
    opened.is_object = is_object;
    opened.stream = stream;
    return !too_deep_;
  }

  [[nodiscard]] const JsonStream* StreamOf(const OpenValue& document) const {
    if (!document.is_object) return nullptr;
    const auto found = std::ranges::find(streams_, document.key, &JsonStream::key);
    return found == streams_.end() ? nullptr : &*found;
  }

  static void Flush(OpenValue& streamed) {
    streamed.stream->take(streamed.num_taken, streamed.array);
    streamed.num_taken += streamed.array.size();
    streamed.array.clear();
  }

  bool Add(JsonValue value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return true;
    }
    too_deep_ = open_.size() > kMaxDepth;
    OpenValue& into = open_.back();
    if (into.is_object) {
      // Of our own files, whose keys are sorted, the next one comes last.
      into.object.insert_or_assign(into.object.end(), std::move(into.key), std::move(value));
    } else {
      into.array.push_back(std::move(value));
      if (into.stream != nullptr && into.array.size() == kElementsAtOnce) Flush(into);
    }
    return !too_deep_;
  }

  std::span<const JsonStream> streams_;
  std::vector<OpenValue> open_;
  JsonValue root_;
  bool too_deep_ = false;
  std::string_view twice_;
  std::string fault_;
};

// Where a value stands in its document: the way from the root, for messages.
struct Place {
  const Place* parent = nullptr;
  const std::string* key = nullptr;  // null: an element of an array
  std::size_t index = 0;

  [[nodiscard]] std::string Path() const {
    if (parent == nullptr) return "";
    const std::string path = parent->Path();
    if (key == nullptr) return path + "[" + std::to_string(index) + "]";
    return path.empty() ? *key : path + "." + *key;
  }
};

// ASCII that stands in JSON as it is.
bool IsPlain(const std::string& string) {
  return std::all_of(string.begin(), string.end(), [](char c) {
    return c >= ' ' && c <= '~' && c != '"' && c != '\\';
  });
}

class Writer {
 public:
  void Write(const JsonValue& value, const Place& place, std::size_t indent) {
    if (const auto* array = value.As<JsonArray>()) {
      WriteArray(*array, place, indent);
    } else if (const auto* rows = value.As<JsonRows>()) {
      WriteRows(*rows, place, indent);
    } else if (const auto* object = value.As<JsonObject>()) {
      WriteObject(*object, place, indent);
    } else {
      WriteScalar(value, place);
    }
  }
  std::string text;
  std::string fault;  // place and reason of the first value that cannot be written

 private:
  void WriteScalar(const JsonValue& value, const Place& place) {
    if (const auto* flag = value.As<bool>()) {
      text += *flag ? "true" : "false";
    } else if (const auto* integer = value.As<std::int64_t>()) {
      text += std::to_string(*integer);
    } else if (const auto* number = value.As<double>()) {
      if (!std::isfinite(*number) && fault.empty()) {
        fault = place.Path() + " is " + ShortestDecimal(*number) + ", which JSON cannot hold";
      }
      text += ShortestDecimal(*number);
    } else if (const auto* string = value.As<std::string>()) {
      WriteString(*string, place);
    } else {
      text += "null";
    }
  }

  void WriteString(const std::string& string, const Place& place) {
    if (IsPlain(string)) {
      text += '"';
      text += string;
      text += '"';
      return;
    }
    try {
      text += nlohmann::json(string).dump();
    } catch (const nlohmann::json::exception&) {
      if (fault.empty()) fault = place.Path() + " is not UTF-8";
    }
  }

  static bool IsScalar(const JsonValue& value) {
    return value.As<JsonArray>() == nullptr && value.As<JsonObject>() == nullptr &&
           value.As<JsonRows>() == nullptr;
  }

  // Arrays of scalars stay on one line; everything else does when it is short.
  void WriteArray(const JsonArray& array, const Place& place, std::size_t indent) {
    bool scalars = true;
    for (const JsonValue& item : array) scalars = scalars && IsScalar(item);
    const std::size_t start = text.size();
    text += '[';
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (i > 0) text += scalars ? ", " : ",";
      if (!scalars) NewLine(indent + 1);
      Write(array[i], {&place, nullptr, i}, indent + 1);
    }
    if (!scalars) NewLine(indent);
    text += ']';
    if (!scalars) Squeeze(start);
  }

  // As an array of objects.
  void WriteRows(const JsonRows& rows, const Place& place, std::size_t indent) {
    const std::size_t start = text.size();
    text += '[';
    for (std::size_t i = 0; i < rows.count; ++i) {
      if (i > 0) text += ',';
      NewLine(indent + 1);
      Write(rows.row(i), {&place, nullptr, i}, indent + 1);
    }
    if (rows.count > 0) NewLine(indent);
    text += ']';
    Squeeze(start);
  }

  void WriteObject(const JsonObject& object, const Place& place, std::size_t indent) {
    const std::size_t start = text.size();
    text += '{';
    bool first = true;
    for (const auto& [key, item] : object) {
      if (!first) text += ',';
      first = false;
      NewLine(indent + 1);
      WriteString(key, place);
      text += ": ";
      Write(item, {&place, &key}, indent + 1);
    }
    if (!object.empty()) NewLine(indent);
    text += '}';
    Squeeze(start);
  }

  void NewLine(std::size_t indent) {
    text += '\n';
    text.append(indent, ' ');
  }

  // Joins what was written since `start` into one line where that is short. Strings hold no raw
  // line breaks.
  void Squeeze(std::size_t start) {
    if (text.size() - start > 2 * kLineWidth) return;
    std::string line;
    for (std::size_t i = start; i < text.size(); ++i) {
      if (text[i] != '\n') {
        line += text[i];
        continue;
      }
      while (i + 1 < text.size() && text[i + 1] == ' ') ++i;
      if (line.back() == ',') line += ' ';
    }
    if (line.size() <= kLineWidth) text.replace(start, std::string::npos, line);
  }
};

}  // namespace

std::string ShortestDecimal(double value) {
  // "-0" would be read as the whole number 0, and written as another text then.
  if (value == 0) return "0";
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

Result<JsonValue> ParseJson(std::string_view text,
                            std::string_view name,
                            std::span<const JsonStream> streams) {
  Builder builder(streams);
  if (nlohmann::json::sax_parse(text, &builder)) return builder.Take();
  if (builder.too_deep())
    return InvalidInput(fmt::format("{}: nested deeper than {} levels", name, kMaxDepth));
  if (!builder.twice().empty())
    return InvalidInput(fmt::format("{}: holds \"{}\" twice", name, builder.twice()));
  // "[json.exception.parse_error.101] parse error at line 3, column 4: ..." -> from "parse error"
  // on.
  std::string what = builder.fault();
  const std::size_t bracket = what.find("] ");
  if (bracket != std::string::npos) what.erase(0, bracket + 2);
  return InvalidInput(fmt::format("{}: not valid JSON: {}", name, what));
}

Result<std::string> DumpJson(const JsonValue& value, std::string_view name) {
  Writer writer;
  writer.Write(value, {}, 0);
  if (!writer.fault.empty()) return Failed(fmt::format("{}: {}", name, writer.fault));
  writer.text += '\n';
  return std::move(writer.text);
}

}  // namespace deepslam::artifact
