// Outcomes as values: what a user can cause or meet comes back as a Status, never as an exception.
//
// A message names the file, the field, the value and what to do about it. A bug is DEEPSLAM_CHECK
// (check.h).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "deepslam/core/check.h"

namespace deepslam {

enum class ErrorCode {
  kFailed,         // failed while running; exit 1
  kInvalidConfig,  // wrong usage or configuration; exit 2
  kInvalidInput,   // input unusable; exit 3
  kInterrupted,    // stopped on request, resumable; exit 130
};

struct Error {
  ErrorCode code = ErrorCode::kFailed;
  std::string message;
};

inline Error Failed(std::string message) { return {ErrorCode::kFailed, std::move(message)}; }
inline Error InvalidConfig(std::string message) {
  return {ErrorCode::kInvalidConfig, std::move(message)};
}
inline Error InvalidInput(std::string message) {
  return {ErrorCode::kInvalidInput, std::move(message)};
}
inline Error Interrupted() { return {ErrorCode::kInterrupted, "interrupted; run again to resume"}; }

// A value or an Error. `value()` on an error is a bug and aborts with the error's message.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    DEEPSLAM_CHECK(ok(), error_message());
    return std::get<0>(content_);
  }
  T& value() & {
    DEEPSLAM_CHECK(ok(), error_message());
    return std::get<0>(content_);
  }
  T&& value() && {
    DEEPSLAM_CHECK(ok(), error_message());
    return std::get<0>(std::move(content_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  const Error& error() const {
    DEEPSLAM_CHECK(!ok(), "error() of a result that holds a value");
    return std::get<1>(content_);
  }

 private:
  std::string error_message() const { return ok() ? std::string() : std::get<1>(content_).message; }
  std::variant<T, Error> content_;
};

// Success or an Error.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    DEEPSLAM_CHECK(error_.has_value(), "error() of a success");
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

inline Status Ok() { return {}; }

}  // namespace deepslam
