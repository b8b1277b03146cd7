// Superpoints into things: what views say is one thing first, what touches without a concave edge
// second, small parts to what they touch most last.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/view_votes.h"

namespace deepslam::instances {

struct MergeOptions {
  // Share of the votes for the same thing with which two parts are merged, and how many votes,
  // weighted by size, that takes.
  double min_consensus = 0.65;
  double min_votes = 1.5;
  // The same of parts that are near each other and do not touch.
  double min_consensus_apart = 0.8;
  double min_votes_apart = 4;
  // Share of a contact's edges that are convex with which parts are merged that views do not tell
  // apart.
  double min_convex_share = 0.55;
  // Length of such a contact in relation to the square root of the smaller part's elements.
  double min_contact_ratio = 0.5;
  double small_part_m2 = 0.06;  // parts with less surface join what they touch most
};
void Describe(OptionsVisitor& visitor, MergeOptions& options);

// Where two superpoints touch: pairs of elements, and how many of them are convex.
struct Contact {
  int num_pairs = 0;
  int num_convex = 0;
};
using Contacts = std::map<SuperpointPair, Contact>;
[[nodiscard]] Contacts FindContacts(const SurfaceElements& elements,
                                    const Superpoints& superpoints,
                                    std::span<const ElementPair> pairs);

// Adds contacts without pairs between superpoints whose boxes come as near to each other as a gap
// in the surface of one thing is wide: between the back of a chair and its seat behind a table top.
void AddNear(const SurfaceElements& elements, const Superpoints& superpoints, Contacts& contacts);

// The number of the thing of each superpoint, in the order of the things' first superpoints.
[[nodiscard]] std::vector<int> MergeSuperpoints(const Superpoints& superpoints,
                                                const Contacts& contacts,
                                                const ViewVotes& votes,
                                                double voxel_m,
                                                const MergeOptions& options);

}  // namespace deepslam::instances
