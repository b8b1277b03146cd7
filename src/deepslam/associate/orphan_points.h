// Points of the detections that found no object and could start none, kept until all objects are
// known. Their number has no bound where a camera sees much at its image's border; their memory
// has.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace deepslam::associate {

class OrphanPoints {
 public:
  using Points = std::vector<Eigen::Vector3f>;

  // Sets are kept whole while they have at most `max_points` together. When they would have more,
  // every second point of each set goes, of later ones as well, and so on; the first one stays.
  explicit OrphanPoints(std::size_t max_points) : max_points_(max_points) {}

  // Returns a key for Take.
  std::size_t Keep(const Points& points);
  // Gives the set out; what is left of it has the order of its points.
  Points Take(std::size_t key);

  [[nodiscard]] std::size_t num_points() const { return num_points_; }

 private:
  std::vector<Points> sets_;  // by key; empty where taken
  std::size_t max_points_;
  std::size_t num_points_ = 0;
  std::size_t step_ = 1;  // of so many points one is kept
};

}  // namespace deepslam::associate
