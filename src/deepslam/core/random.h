// Deterministic random numbers, the same on every platform: std distributions differ between
// libraries, these do not. A Random is an argument, seeded from (run seed, name of the work, item);
// there is no global one.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace deepslam {

// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  Random(std::uint64_t seed, std::string_view work, std::uint64_t item) : state_(seed) {
    for (const char c : work)
      state_ = Next() ^ static_cast<std::uint64_t>(static_cast<unsigned char>(c));
    state_ = Next() ^ item;
    Next();
  }

  std::uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  // Uniform in [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // Uniform in {0, ..., count - 1}; count > 0.
  std::uint64_t Index(std::uint64_t count) { return Next() % count; }
  // Standard normal (Box-Muller).
  double Normal() {
    const double u = 1.0 - Uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace deepslam
