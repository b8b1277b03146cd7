#include "deepslam/mesh/relax_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace deepslam::mesh {
namespace {

// What a leg of one or two voxels keeps at least of its width, voxels. A slanting leg of one and a
// half voxels is one voxel wide here and two there: both may become what it is.
constexpr std::array<double, kThinVoxels + 1> kKeptThinWidth = {0, 0.8, 1.1};
// Below the inverse of the largest eigenvalue of the squared umbrella operator, which is at most 4
// for equal valences.
constexpr double kStepSize = 0.2;

// Momentum beyond this lets the slowest modes overshoot: the middle of a board would bulge as its
// edges round.
constexpr double kMaxMomentum = 0.85;

// Bends (length of the umbrella vector, voxels) beyond this count by their length, no longer by its
// square: the edges of a board then stay edges instead of swelling its faces. It shrinks while the
// stairs go. Smaller at the end makes sharper edges, and keeps steps that are as sharp.
constexpr double kFirstBend = 2.0;
constexpr double kLastBend = 0.35;  // at the end of the iterations

// Edges from a step within which its face may be slanted; beyond, the face is level. Of flatter
// slants the steps stay to be seen.
constexpr int kStepReach = 4;

// Neighbours of vertex v are indices[starts[v]] .. indices[starts[v + 1] - 1].
struct Adjacency {
  std::vector<std::size_t> starts;
  std::vector<std::uint32_t> indices;
  std::vector<double> inverse_degree;
};

Adjacency BuildAdjacency(const VoxelBoundary& boundary) {
  // Each edge of a closed oriented mesh is run through once in each direction: half edges count
  // every neighbour once.
  Adjacency result;
  result.starts.assign(boundary.vertices.size() + 1, 0);
  for (const auto& quad : boundary.quads) {
    for (const std::uint32_t v : quad) ++result.starts[v + 1];
  }
  for (std::size_t v = 0; v < boundary.vertices.size(); ++v) {
    result.inverse_degree.push_back(1.0 / static_cast<double>(result.starts[v + 1]));
    result.starts[v + 1] += result.starts[v];
  }
  result.indices.resize(result.starts.back());
  std::vector<std::size_t> next(result.starts.begin(), result.starts.end() - 1);
  for (const auto& quad : boundary.quads) {
    for (std::size_t n = 0; n < 4; ++n) result.indices[next[quad[n]]++] = quad[(n + 1) % 4];
  }
  return result;
}

using Points = std::vector<Eigen::Vector3d>;

// Umbrella vectors in their robust weight, plain and over the degree: what the gradient of the
// energy needs.
void WeightedUmbrella(
    const Adjacency& adjacency, const Points& p, double soft_bend, Points& scaled, Points& plain) {
  for (std::size_t v = 0; v < p.size(); ++v) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t n = adjacency.starts[v]; n < adjacency.starts[v + 1]; ++n) {
      sum += p[adjacency.indices[n]];
    }
    plain[v] = sum * adjacency.inverse_degree[v] - p[v];
    const double bend = plain[v].norm() / soft_bend;
    plain[v] /= std::sqrt(1.0 + bend * bend);
    scaled[v] = plain[v] * adjacency.inverse_degree[v];
  }
}

// Edges from each vertex to the nearest foot of a step along the axis; kStepReach at most.
std::vector<int> EdgesToStep(const VoxelBoundary& boundary, const Adjacency& adjacency, int axis) {
  std::vector<int> edges(boundary.vertices.size(), kStepReach);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t v = 0; v < edges.size(); ++v) {
    if (boundary.at_step[v][static_cast<std::size_t>(axis)] == 0) continue;
    edges[v] = 0;
    queue.push_back(v);
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const std::uint32_t v = queue[head];
    for (std::size_t n = adjacency.starts[v]; n < adjacency.starts[v + 1]; ++n) {
      const std::uint32_t next = adjacency.indices[n];
      if (edges[next] <= edges[v] + 1) continue;
      edges[next] = edges[v] + 1;
      queue.push_back(next);
    }
  }
  return edges;
}

// Of each vertex's way from its corner, per axis. A slant passes half a voxel off the corners at
// its steps, and through them midway between two.
Points BoundsOf(const VoxelBoundary& boundary, const Adjacency& adjacency, double max_shift) {
  Points bounds(boundary.vertices.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int> edges = EdgesToStep(boundary, adjacency, axis);
    for (std::size_t v = 0; v < bounds.size(); ++v)
      bounds[v][axis] = max_shift * (1.0 - static_cast<double>(edges[v]) / kStepReach);
  }
  return bounds;
}

void Project(const VoxelBoundary& boundary, const Points& bounds, Points& p) {
  for (const ThinPair& pair : boundary.thin_pairs) {
    double& low = p[pair.low][pair.axis];
    double& high = p[pair.high][pair.axis];
    const double missing = kKeptThinWidth[static_cast<std::size_t>(pair.width)] - (high - low);
    if (missing <= 0) continue;
    low -= 0.5 * missing;
    high += 0.5 * missing;
  }
  for (std::size_t v = 0; v < p.size(); ++v) {
    const Eigen::Vector3d shift = p[v] - boundary.vertices[v];
    p[v] = boundary.vertices[v] + shift.cwiseMax(-bounds[v]).cwiseMin(bounds[v]);
  }
}

}  // namespace

// Accelerated projected gradient (Beck and Teboulle 2009): long steps of a slightly tilted plane
// have small eigenvalues and would need thousands of plain steps.
std::vector<Eigen::Vector3d> RelaxBoundary(const VoxelBoundary& boundary,
                                           int iterations,
                                           double max_shift) {
  const Adjacency adjacency = BuildAdjacency(boundary);
  const Points bounds = BoundsOf(boundary, adjacency, max_shift);
  Points current = boundary.vertices;
  Points previous = current;
  Points scaled(current.size());
  Points plain(current.size());
  double momentum = 1.0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const double next_momentum = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum));
    const double weight = std::min(kMaxMomentum, (momentum - 1.0) / next_momentum);
    momentum = next_momentum;
    Points ahead(current.size());
    for (std::size_t v = 0; v < current.size(); ++v) {
      ahead[v] = current[v] + weight * (current[v] - previous[v]);
    }
    const double share = static_cast<double>(iteration) / iterations;
    const double bend = kFirstBend * std::pow(kLastBend / kFirstBend, share);
    WeightedUmbrella(adjacency, ahead, bend, scaled, plain);
    for (std::size_t v = 0; v < current.size(); ++v) {
      Eigen::Vector3d gradient = -plain[v];
      for (std::size_t n = adjacency.starts[v]; n < adjacency.starts[v + 1]; ++n) {
        gradient += scaled[adjacency.indices[n]];
      }
      ahead[v] -= kStepSize * gradient;
    }
    Project(boundary, bounds, ahead);
    previous = std::move(current);
    current = std::move(ahead);
  }
  return current;
}

}  // namespace deepslam::mesh
