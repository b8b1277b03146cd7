// SHA-256 of bytes as 64 lower-case hex digits; the name by which artifacts and inputs are known.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace deepslam {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void Update(std::string_view bytes);
  // Ends the digest; the object must not be used afterwards.
  [[nodiscard]] std::string HexDigest();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

[[nodiscard]] std::string Sha256Hex(std::string_view bytes);

}  // namespace deepslam
