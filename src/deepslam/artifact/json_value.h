// JSON values with sorted keys, so that equal values are equal bytes. Doubles are written in their
// shortest form that reads back exactly; a number that is not finite refuses to be written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"

namespace deepslam::artifact {

class JsonValue;
using JsonArray = std::vector<JsonValue>;
using JsonObject = std::map<std::string, JsonValue, std::less<>>;

// An array whose elements are made as they are written, each once and in their order: a table with
// rows for each frame of a long capture is never there as values. `row` refers to what it is made
// of, which has to outlive the writing.
struct JsonRows {
  std::size_t count = 0;
  std::function<JsonValue(std::size_t index)> row;
};

class JsonValue {
 public:
  using Content = std::variant<std::nullptr_t,
                               bool,
                               std::int64_t,
                               double,
                               std::string,
                               JsonArray,
                               JsonObject,
                               JsonRows>;

  JsonValue() : content_(nullptr) {}
  JsonValue(std::nullptr_t) : content_(nullptr) {}  // NOLINT(google-explicit-constructor)
  JsonValue(bool value) : content_(value) {}        // NOLINT(google-explicit-constructor)
  JsonValue(int value)
      : content_(static_cast<std::int64_t>(value)) {}  // NOLINT(google-explicit-constructor)
  JsonValue(std::int64_t value) : content_(value) {}   // NOLINT(google-explicit-constructor)
  JsonValue(double value) : content_(value) {}         // NOLINT(google-explicit-constructor)
  JsonValue(float value)
      : content_(static_cast<double>(value)) {}  // NOLINT(google-explicit-constructor)
  JsonValue(const char* value)
      : content_(std::string(value)) {}  // NOLINT(google-explicit-constructor)
  JsonValue(std::string value)
      : content_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  JsonValue(std::string_view value)
      : content_(std::string(value)) {}                       // NOLINT(google-explicit-constructor)
  JsonValue(JsonArray value) : content_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  JsonValue(JsonObject value)
      : content_(std::move(value)) {}                      // NOLINT(google-explicit-constructor)
  JsonValue(JsonRows rows) : content_(std::move(rows)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] const Content& content() const { return content_; }
  [[nodiscard]] bool is_null() const { return std::holds_alternative<std::nullptr_t>(content_); }
  // The value as T, or nullptr when it holds something else.
  template <typename T>
  [[nodiscard]] const T* As() const {
    return std::get_if<T>(&content_);
  }

 private:
  Content content_;
};

// The rows of a list, each as `to_json` has its element.
template <typename List, typename ToJson>
[[nodiscard]] JsonValue RowsOf(const List& list, const ToJson& to_json) {
  return JsonRows{list.size(),
                  [&list, to_json](std::size_t i) { return JsonValue(to_json(list[i])); }};
}

// The same on the way in: elements of an array that is a member of the document, or with an empty
// key the document itself, handed over a few at a time; of the value the array is left empty.
struct JsonStream {
  std::string_view key;
  std::function<void(std::size_t first, std::span<const JsonValue> elements)> take;
};

// `name` is what messages call the text (a file name). Refuses text that is no JSON, nested deeper
// than 64 levels or with numbers out of range, with line and column; and a streamed array that
// comes twice. Errors of the text come as they are.
[[nodiscard]] Result<JsonValue> ParseJson(TextSource text,
                                          std::string_view name,
                                          std::span<const JsonStream> streams = {});

// Fails on numbers that are not finite and on strings that are not UTF-8, naming the place. By
// pieces of some rows each, or as a whole; the pieces before a fault were handed over.
[[nodiscard]] Status DumpJson(const JsonValue& value, std::string_view name, const TextSink& sink);
[[nodiscard]] Result<std::string> DumpJson(const JsonValue& value, std::string_view name);

// Shortest decimal form that reads back as the same double ("0.1", "1e-07"); "nan" and "inf" for
// those, "0" for minus zero.
[[nodiscard]] std::string ShortestDecimal(double value);

}  // namespace deepslam::artifact
