// Reads typed values out of a JSON document and remembers the first fault with its place, so that
// decoders stay straight lines: read everything, then ask Finish() whether it was sound.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"

namespace deepslam::artifact {

class JsonReader;

// A place in a document. Reading something absent or of the wrong type records a fault and returns
// a zero value.
class JsonNode {
 public:
  [[nodiscard]] bool exists() const { return value_ != nullptr && !value_->is_null(); }
  [[nodiscard]] bool is_array() const {
    return value_ != nullptr && value_->As<JsonArray>() != nullptr;
  }
  [[nodiscard]] bool is_object() const {
    return value_ != nullptr && value_->As<JsonObject>() != nullptr;
  }
  [[nodiscard]] bool is_string() const {
    return value_ != nullptr && value_->As<std::string>() != nullptr;
  }
  [[nodiscard]] bool is_number() const {
    return value_ != nullptr &&
           (value_->As<double>() != nullptr || value_->As<std::int64_t>() != nullptr);
  }
  // A member that must be there; a member that may be missing or null (then !exists()).
  [[nodiscard]] JsonNode operator[](std::string_view key) const;
  [[nodiscard]] JsonNode Maybe(std::string_view key) const;

  [[nodiscard]] double Number() const;
  [[nodiscard]] double Number(double min, double max) const;
  [[nodiscard]] int Int(int min, int max) const;
  [[nodiscard]] bool Bool() const;
  [[nodiscard]] std::string String() const;
  // Elements of an array; `count` < 0: any number of them, else exactly that many (zero values
  // where it has fewer).
  [[nodiscard]] std::vector<JsonNode> Items(int count = -1) const;
  [[nodiscard]] std::vector<double> Numbers(int count) const;
  // Members of an object, ascending keys.
  [[nodiscard]] std::vector<std::pair<std::string, JsonNode>> Members() const;
  void Fail(std::string_view what) const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  friend class JsonReader;
  JsonNode(JsonReader* reader, const JsonValue* value, std::string path)
      : reader_(reader), value_(value), path_(std::move(path)) {}
  JsonReader* reader_;
  const JsonValue* value_;
  std::string path_;
};

// An array among the document's members, or with an empty key the document itself, whose rows are
// read as they are parsed, a few at a time and in their order, and gone then: for tables that grow
// with the length of a capture.
struct JsonTable {
  std::string_view key;
  std::function<void(std::span<const JsonNode> rows)> read;
  bool must_be_there = true;
};

// What the fields "format" and "version" of a file of the program's own say.
struct JsonFormat {
  std::string_view name;
  int version = 1;
  int oldest = 0;  // version that is read as well; 0: none older
};

class JsonReader {
 public:
  // `name` is the file's name for messages. Checks the document's "format" and "version" fields;
  // pass an empty format for foreign documents that have none.
  JsonReader(TextSource text,
             std::string_view name,
             std::string_view format,
             int version,
             std::vector<JsonTable> tables = {});
  JsonReader(TextSource text,
             std::string_view name,
             const JsonFormat& format,
             std::vector<JsonTable> tables = {});
  JsonReader(const JsonReader&) = delete;
  JsonReader& operator=(const JsonReader&) = delete;

  [[nodiscard]] JsonNode root() { return {this, ok() ? &document_ : nullptr, ""}; }
  [[nodiscard]] bool ok() const { return fault_.empty(); }
  [[nodiscard]] Error error() const { return InvalidInput(fault_); }
  void Fail(std::string_view path, std::string_view what);
  // The value, or the first fault of the document.
  template <typename T>
  [[nodiscard]] Result<T> Finish(T value) const {
    if (!ok()) return error();
    return value;
  }

 private:
  void CheckFormat(const JsonFormat& format);
  std::string name_;
  JsonValue document_;
  std::string fault_;
};

// An object that starts with the fields every artifact has.
[[nodiscard]] JsonObject NewDocument(std::string_view format, int version);

}  // namespace deepslam::artifact
