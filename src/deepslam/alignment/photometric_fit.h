// What intensity of frame j becomes in frame i, fitted to pairs of pixels that show the same
// point: exposure, and the lens's darkening towards the corners.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/alignment/batch_columns.h"

namespace deepslam::alignment {

inline constexpr float kMiddleGrey = 128.0F;  // of 8 bits
// Holds the falloff near 0, give or take 1, where the frames see alike: squared grey levels, those
// of a residual of 5 that some 20 pixels share.
inline constexpr double kFalloffPrior = 500;
// Fewer pairs (a sum of weights), or less contrast (standard deviation, grey levels), give no fit.
inline constexpr double kMinFittedPairs = 50;
inline constexpr double kMinFittedContrast = 5;  // grey levels: a camera's noise leaves 2
// Exposure changes within a factor of two between aligned frames; a fit beyond that is a wrong
// alignment.
inline constexpr double kMinGain = 0.5;
inline constexpr double kMaxGain = 2.0;  // and its inverse, whichever of the two is the reference

// Weighted I_i = gain * I_j + bias + falloff * darker, `darker` being I_j * (rho_i^2 - rho_j^2).
class PhotometricFit {
 public:
  // Grey levels less kMiddleGrey, so that little is lost when means are subtracted; `size` is a
  // multiple of kLanes.
  void Add(const Column& source, const Column& reference, const Column& weight, std::size_t size) {
    Lanes all{}, s{}, t{}, ss{}, st{}, tt{};
    for (std::size_t k = 0; k < size; k += kLanes) {
      const Lanes &w = LanesAt(weight, k), &of_source = LanesAt(source, k),
                  &of_reference = LanesAt(reference, k);
      const Lanes weighted_source = w * of_source, weighted_reference = w * of_reference;
      all += w;
      s += weighted_source;
      t += weighted_reference;
      ss += weighted_source * of_source;
      st += weighted_source * of_reference;
      tt += weighted_reference * of_reference;
    }
    sum_ += SumOf(all);
    sum_s_ += SumOf(s);
    sum_t_ += SumOf(t);
    sum_ss_ += SumOf(ss);
    sum_st_ += SumOf(st);
    sum_tt_ += SumOf(tt);
  }
  // Of the same pairs, where falloff is to be fitted.
  void AddFalloff(const Column& source,
                  const Column& reference,
                  const Column& darker,
                  const Column& weight,
                  std::size_t size) {
    Lanes d{}, sd{}, td{}, dd{};
    for (std::size_t k = 0; k < size; k += kLanes) {
      const Lanes weighted = LanesAt(weight, k) * LanesAt(darker, k);
      d += weighted;
      sd += weighted * LanesAt(source, k);
      td += weighted * LanesAt(reference, k);
      dd += weighted * LanesAt(darker, k);
    }
    sum_d_ += SumOf(d);
    sum_sd_ += SumOf(sd);
    sum_td_ += SumOf(td);
    sum_dd_ += SumOf(dd);
  }
  // Of the two intensities; 0 where one of them does not vary.
  [[nodiscard]] double Correlation() const {
    const double product = (sum_ss_ * sum_ - sum_s_ * sum_s_) * (sum_tt_ * sum_ - sum_t_ * sum_t_);
    return product > 0 ? (sum_st_ * sum_ - sum_s_ * sum_t_) / std::sqrt(product) : 0;
  }
  // Leaves all three as they are where the pairs are too few or all of one intensity.
  void Solve(float& gain, float& bias, float& falloff) const {
    const double ss = sum_ss_ * sum_ - sum_s_ * sum_s_;
    constexpr double kMinVariance = kMinFittedContrast * kMinFittedContrast;
    if (sum_ < kMinFittedPairs || ss <= kMinVariance * sum_ * sum_) return;
    const double st = sum_st_ * sum_ - sum_s_ * sum_t_, sd = sum_sd_ * sum_ - sum_s_ * sum_d_;
    const double td = sum_td_ * sum_ - sum_t_ * sum_d_;
    const double dd = (sum_dd_ + kFalloffPrior) * sum_ - sum_d_ * sum_d_;
    const double of_darker = (td * ss - st * sd) / (dd * ss - sd * sd);
    const double slope = std::clamp((st - of_darker * sd) / ss, kMinGain, kMaxGain);
    gain = static_cast<float>(slope);
    falloff = static_cast<float>(of_darker);
    bias = static_cast<float>((sum_t_ - slope * sum_s_ - of_darker * sum_d_) / sum_) +
           (1 - gain) * kMiddleGrey;
  }

 private:
  double sum_ = 0, sum_s_ = 0, sum_t_ = 0, sum_ss_ = 0, sum_st_ = 0, sum_tt_ = 0;
  double sum_d_ = 0, sum_sd_ = 0, sum_td_ = 0, sum_dd_ = 0;
};

}  // namespace deepslam::alignment
