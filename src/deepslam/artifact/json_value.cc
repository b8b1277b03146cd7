#include "deepslam/artifact/json_value.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace deepslam::artifact {
namespace {

constexpr int kMaxDepth = 64;
constexpr std::size_t kLineWidth = 100;

// Nothing when the value is nested too deeply.
std::optional<JsonValue> FromNlohmann(const nlohmann::json& in, int depth) {
  if (depth > kMaxDepth) return std::nullopt;
  switch (in.type()) {
    case nlohmann::json::value_t::boolean:
      return JsonValue(in.get<bool>());
    case nlohmann::json::value_t::number_integer:
      return JsonValue(in.get<std::int64_t>());
    case nlohmann::json::value_t::number_unsigned: {
      const auto value = in.get<std::uint64_t>();
      if (value > static_cast<std::uint64_t>(INT64_MAX))
        return JsonValue(static_cast<double>(value));
      return JsonValue(static_cast<std::int64_t>(value));
    }
    case nlohmann::json::value_t::number_float:
      return JsonValue(in.get<double>());
    case nlohmann::json::value_t::string:
      return JsonValue(in.get<std::string>());
    case nlohmann::json::value_t::array: {
      JsonArray array;
      array.reserve(in.size());
      for (const nlohmann::json& item : in) {
        std::optional<JsonValue> value = FromNlohmann(item, depth + 1);
        if (!value) return std::nullopt;
        array.push_back(std::move(*value));
      }
      return JsonValue(std::move(array));
    }
    case nlohmann::json::value_t::object: {
      JsonObject object;
      for (const auto& [key, item] : in.items()) {
        std::optional<JsonValue> value = FromNlohmann(item, depth + 1);
        if (!value) return std::nullopt;
        object.emplace(key, std::move(*value));
      }
      return JsonValue(std::move(object));
    }
    default:
      return JsonValue();
  }
}

class Writer {
 public:
  void Write(const JsonValue& value, const std::string& path, std::size_t indent) {
    if (const auto* array = value.As<JsonArray>()) {
      WriteArray(*array, path, indent);
    } else if (const auto* object = value.As<JsonObject>()) {
      WriteObject(*object, path, indent);
    } else {
      WriteScalar(value, path);
    }
  }
  std::string text;
  std::string fault;  // place and reason of the first value that cannot be written

 private:
  void WriteScalar(const JsonValue& value, const std::string& path) {
    if (const auto* flag = value.As<bool>()) {
      text += *flag ? "true" : "false";
    } else if (const auto* integer = value.As<std::int64_t>()) {
      text += std::to_string(*integer);
    } else if (const auto* number = value.As<double>()) {
      if (!std::isfinite(*number) && fault.empty()) {
        fault = path + " is " + ShortestDecimal(*number) + ", which JSON cannot hold";
      }
      text += ShortestDecimal(*number);
    } else if (const auto* string = value.As<std::string>()) {
      WriteString(*string, path);
    } else {
      text += "null";
    }
  }

  void WriteString(const std::string& string, const std::string& path) {
    try {
      text += nlohmann::json(string).dump();
    } catch (const nlohmann::json::exception&) {
      if (fault.empty()) fault = path + " is not UTF-8";
    }
  }

  static bool IsScalar(const JsonValue& value) {
    return value.As<JsonArray>() == nullptr && value.As<JsonObject>() == nullptr;
  }

  // Arrays of scalars stay on one line; everything else does when it is short.
  void WriteArray(const JsonArray& array, const std::string& path, std::size_t indent) {
    bool scalars = true;
    for (const JsonValue& item : array) scalars = scalars && IsScalar(item);
    const std::size_t start = text.size();
    text += '[';
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (i > 0) text += scalars ? ", " : ",";
      if (!scalars) NewLine(indent + 1);
      Write(array[i], path + "[" + std::to_string(i) + "]", indent + 1);
    }
    if (!scalars) NewLine(indent);
    text += ']';
    if (!scalars) Squeeze(start);
  }

  void WriteObject(const JsonObject& object, const std::string& path, std::size_t indent) {
    const std::size_t start = text.size();
    text += '{';
    bool first = true;
    for (const auto& [key, item] : object) {
      if (!first) text += ',';
      first = false;
      NewLine(indent + 1);
      WriteString(key, path);
      text += ": ";
      Write(item, path.empty() ? key : path + "." + key, indent + 1);
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

Result<JsonValue> ParseJson(std::string_view text, std::string_view name) {
  try {
    const nlohmann::json parsed = nlohmann::json::parse(text);
    std::optional<JsonValue> value = FromNlohmann(parsed, 0);
    if (!value)
      return InvalidInput(fmt::format("{}: nested deeper than {} levels", name, kMaxDepth));
    return *std::move(value);
  } catch (const nlohmann::json::exception& e) {
    // "[json.exception.parse_error.101] parse error at line 3, column 4: ..." -> from "parse error"
    // on.
    std::string what = e.what();
    const std::size_t bracket = what.find("] ");
    if (bracket != std::string::npos) what.erase(0, bracket + 2);
    return InvalidInput(fmt::format("{}: not valid JSON: {}", name, what));
  }
}

Result<std::string> DumpJson(const JsonValue& value, std::string_view name) {
  Writer writer;
  writer.Write(value, "", 0);
  if (!writer.fault.empty()) return Failed(fmt::format("{}: {}", name, writer.fault));
  writer.text += '\n';
  return std::move(writer.text);
}

}  // namespace deepslam::artifact
