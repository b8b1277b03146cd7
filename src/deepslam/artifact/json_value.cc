#include "deepslam/artifact/json_value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace deepslam::artifact {
namespace {

// Hostile text cannot exhaust the stack; own files nest far less.
constexpr std::size_t kMaxNesting = 64;
constexpr std::size_t kLineWidth = 100;  // columns: an array that fits is written on one line
constexpr std::size_t kSqueezable = 2 * kLineWidth;  // with line breaks and indents
// 256 KiB: what is held of a long file while it is written.
constexpr std::size_t kPieceBytes = std::size_t{1} << 18;
constexpr std::size_t kElementsAtOnce = 64;  // of a stream; enough to work on side by side

// Where the parser stands in a text that comes by pieces.
class Cursor {
 public:
  explicit Cursor(TextSource text) : text_(std::move(text)) {}

  // Whether there is a character here; moves on to the next piece where one ends.
  [[nodiscard]] bool HasCharacter() { return at_ != end_ || Refill(); }
  [[nodiscard]] const char& character() const { return *at_; }
  void Advance() { ++at_; }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  bool Refill() {
    if (is_done_) return false;
    const Result<std::string_view> piece = text_.Next();
    if (!piece.ok()) status_ = piece.error();
    is_done_ = !piece.ok() || piece->empty();
    if (is_done_) return false;
    at_ = piece->data();
    end_ = at_ + piece->size();
    return true;
  }

  TextSource text_;
  const char* at_ = nullptr;
  const char* end_ = nullptr;
  bool is_done_ = false;
  Status status_;
};

// The cursor as the parser wants it: a pair of iterators, of which the one without a cursor is the
// end.
class CursorIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CursorIterator() = default;
  explicit CursorIterator(Cursor& cursor) : cursor_(&cursor) {}

  reference operator*() const { return cursor_->character(); }
  CursorIterator& operator++() {
    cursor_->Advance();
    return *this;
  }
  friend bool operator==(const CursorIterator& a, const CursorIterator& b) {
    return a.IsAtEnd() == b.IsAtEnd();
  }

 private:
  [[nodiscard]] bool IsAtEnd() const { return cursor_ == nullptr || !cursor_->HasCharacter(); }
  Cursor* cursor_ = nullptr;
};

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
    too_deep_ = open_.size() > kMaxNesting;
    const JsonStream* const stream = is_object ? nullptr : StreamOfNext();
    if (stream != nullptr && !open_.empty() && open_[0].object.contains(stream->key)) {
      twice_ = stream->key;
      return false;
    }
    OpenValue& opened = open_.emplace_back();
    opened.is_object = is_object;
    opened.stream = stream;
    return !too_deep_;
  }

  // Of an array that begins here.
  [[nodiscard]] const JsonStream* StreamOfNext() const {
    const bool is_member = open_.size() == 1 && open_[0].is_object && !open_[0].key.empty();
    if (!open_.empty() && !is_member) return nullptr;
    const std::string_view key = is_member ? std::string_view(open_[0].key) : "";
    const auto found = std::ranges::find(streams_, key, &JsonStream::key);
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
    too_deep_ = open_.size() > kMaxNesting;
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
  explicit Writer(const TextSink& sink) : sink_(sink) {}

  // All of it; `name` is the file's.
  Status WriteDocument(const JsonValue& value, std::string_view name) {
    Write(value, {}, 0);
    text_ += '\n';
    PassOn(0);
    if (!fault_.empty()) return Failed(fmt::format("{}: {}", name, fault_));
    return status_;
  }

 private:
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

  // All but the last `keep` characters, to which somebody may still go back.
  void PassOn(std::size_t keep) {
    const std::size_t count = text_.size() - std::min(keep, text_.size());
    if (status_.ok() && fault_.empty()) status_ = sink_(std::string_view(text_).substr(0, count));
    text_.erase(0, count);
    num_passed_on_ += count;
  }
  // Characters of the document so far.
  [[nodiscard]] std::size_t size() const { return num_passed_on_ + text_.size(); }

  void WriteScalar(const JsonValue& value, const Place& place) {
    if (const auto* flag = value.As<bool>()) {
      text_ += *flag ? "true" : "false";
    } else if (const auto* integer = value.As<std::int64_t>()) {
      text_ += std::to_string(*integer);
    } else if (const auto* number = value.As<double>()) {
      if (!std::isfinite(*number) && fault_.empty()) {
        fault_ = place.Path() + " is " + ShortestDecimal(*number) + ", which JSON cannot hold";
      }
      text_ += ShortestDecimal(*number);
    } else if (const auto* string = value.As<std::string>()) {
      WriteString(*string, place);
    } else {
      text_ += "null";
    }
  }

  void WriteString(const std::string& string, const Place& place) {
    if (IsPlain(string)) {
      text_ += '"';
      text_ += string;
      text_ += '"';
      return;
    }
    try {
      text_ += nlohmann::json(string).dump();
    } catch (const nlohmann::json::exception&) {
      if (fault_.empty()) fault_ = place.Path() + " is not UTF-8";
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
    const std::size_t start = size();
    text_ += '[';
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (i > 0) text_ += scalars ? ", " : ",";
      if (!scalars) NewLine(indent + 1);
      Write(array[i], {&place, nullptr, i}, indent + 1);
    }
    if (!scalars) NewLine(indent);
    text_ += ']';
    if (!scalars) Squeeze(start);
  }

  // As an array of objects.
  void WriteRows(const JsonRows& rows, const Place& place, std::size_t indent) {
    const std::size_t start = size();
    text_ += '[';
    for (std::size_t i = 0; i < rows.count && status_.ok(); ++i) {
      if (i > 0) text_ += ',';
      NewLine(indent + 1);
      Write(rows.row(i), {&place, nullptr, i}, indent + 1);
      if (text_.size() > kPieceBytes) PassOn(kSqueezable);
    }
    if (rows.count > 0) NewLine(indent);
    text_ += ']';
    Squeeze(start);
  }

  void WriteObject(const JsonObject& object, const Place& place, std::size_t indent) {
    const std::size_t start = size();
    text_ += '{';
    bool first = true;
    for (const auto& [key, item] : object) {
      if (!first) text_ += ',';
      first = false;
      NewLine(indent + 1);
      WriteString(key, place);
      text_ += ": ";
      Write(item, {&place, &key}, indent + 1);
    }
    if (!object.empty()) NewLine(indent);
    text_ += '}';
    Squeeze(start);
  }

  void NewLine(std::size_t indent) {
    text_ += '\n';
    text_.append(indent, ' ');
  }

  // Joins what was written since `start` into one line where that is short. Strings hold no raw
  // line breaks.
  void Squeeze(std::size_t start) {
    if (size() - start > kSqueezable) return;
    const std::size_t begin = start - num_passed_on_;
    std::string line;
    for (std::size_t i = begin; i < text_.size(); ++i) {
      if (text_[i] != '\n') {
        line += text_[i];
        continue;
      }
      while (i + 1 < text_.size() && text_[i + 1] == ' ') ++i;
      if (line.back() == ',') line += ' ';
    }
    if (line.size() <= kLineWidth) text_.replace(begin, std::string::npos, line);
  }

  const TextSink& sink_;
  Status status_;                  // of the sink
  std::string text_;               // what was not handed over yet
  std::size_t num_passed_on_ = 0;  // characters before it
  std::string fault_;              // place and reason of the first value that cannot be written
};

}  // namespace

std::string ShortestDecimal(double value) {
  // "-0" would be read as the whole number 0, and written as another text then.
  if (value == 0) return "0";
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

Result<JsonValue> ParseJson(TextSource text,
                            std::string_view name,
                            std::span<const JsonStream> streams) {
  Builder builder(streams);
  Cursor cursor(std::move(text));
  const bool is_sound =
      nlohmann::json::sax_parse(CursorIterator(cursor), CursorIterator(), &builder);
  if (!cursor.status().ok()) return cursor.status().error();
  if (is_sound) return builder.Take();
  if (builder.too_deep())
    return InvalidInput(fmt::format("{}: nested deeper than {} levels", name, kMaxNesting));
  if (!builder.twice().empty())
    return InvalidInput(fmt::format("{}: holds \"{}\" twice", name, builder.twice()));
  // "[json.exception.parse_error.101] parse error at line 3, column 4: ..." -> from "parse error"
  // on.
  std::string what = builder.fault();
  const std::size_t bracket = what.find("] ");
  if (bracket != std::string::npos) what.erase(0, bracket + 2);
  return InvalidInput(fmt::format("{}: not valid JSON: {}", name, what));
}

Status DumpJson(const JsonValue& value, std::string_view name, const TextSink& sink) {
  return Writer(sink).WriteDocument(value, name);
}

Result<std::string> DumpJson(const JsonValue& value, std::string_view name) {
  return WholeText([&](const TextSink& sink) { return DumpJson(value, name, sink); });
}

}  // namespace deepslam::artifact
