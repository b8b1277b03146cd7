// The JSON of a glTF, which is never trusted: typed values of its places, and a finding where one
// is not what it has to be.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/gltf/findings.h"

namespace deepslam::gltf {

// A place in the document, whether or not something is there. Good as long as its GltfJson.
class JsonPlace {
 public:
  [[nodiscard]] bool exists() const { return value_ != nullptr; }
  [[nodiscard]] bool IsObject() const;
  // As in "meshes[2].primitives[0]".
  [[nodiscard]] const std::string& name() const { return name_; }

  // The same, told with the name that its content gives it: "nodes[3] 'chair_03'".
  [[nodiscard]] JsonPlace Named(const std::string& own_name) const {
    return {value_, name_ + " '" + own_name + "'", *findings_};
  }

  // A member; of what is no object: a place where nothing is.
  [[nodiscard]] JsonPlace operator[](const std::string& member) const;
  [[nodiscard]] std::vector<std::string> Members() const;
  // Elements of a list; 0 where there is none. One that is no list is an error.
  [[nodiscard]] std::size_t Size() const;
  [[nodiscard]] JsonPlace At(std::size_t element) const;  // below Size()

  // `fallback`, or false, where nothing is; an error, and the same, where it is something else.
  [[nodiscard]] std::uint64_t Whole(std::uint64_t fallback) const;
  [[nodiscard]] double Number(double fallback) const;  // finite
  bool Numbers(std::span<double> numbers) const;       // a list of as many finite ones
  // Below `size`; -1 where nothing is, or an error.
  [[nodiscard]] int Index(std::size_t size) const;
  [[nodiscard]] std::vector<int> Indices(std::size_t size) const;
  // Nothing, and no finding, where it is something else.
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] std::optional<std::int64_t> MaybeWhole() const;  // with its sign
  [[nodiscard]] std::optional<double> MaybeNumber() const;
  [[nodiscard]] bool IsTrue() const;
  [[nodiscard]] std::string Dump() const;  // as ASCII, for messages

  void Error(const std::string& what) const { findings_->Error(name_, what); }
  void Breach(const std::string& what) const { findings_->Breach(name_, what); }
  void Warn(const std::string& what) const { findings_->Warn(name_, what); }
  // Of the whole document so far.
  [[nodiscard]] std::size_t num_errors() const { return findings_->num_errors; }

 private:
  friend class GltfJson;
  JsonPlace(const void* value, std::string name, Findings& findings)
      : value_(value), name_(std::move(name)), findings_(&findings) {}

  const void* value_;  // of the JSON library
  std::string name_;
  Findings* findings_;
};

class GltfJson {
 public:
  // Nothing where it is no JSON object or nested too deeply; `findings`, which has to outlive this,
  // says so.
  [[nodiscard]] static std::optional<GltfJson> Parse(std::string_view text, Findings& findings);
  [[nodiscard]] JsonPlace root() const { return {document_.get(), "", *findings_}; }

 private:
  GltfJson(std::shared_ptr<const void> document, Findings& findings)
      : document_(std::move(document)), findings_(&findings) {}

  std::shared_ptr<const void> document_;  // shared: it knows how to end it without its type
  Findings* findings_;
};

}  // namespace deepslam::gltf
