#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "domain.h"

namespace insitu::blueprint {

/// A Blueprint mesh as a mesh of a session, kept up to date with the tree that the solver gives.
class Attachment {
public:
  explicit Attachment(insitu_mesh mesh) : mesh_(mesh) {}

  struct Options {
    std::string topology; ///< its name; empty: the first one of cells with volume
    bool lacking = false; ///< domains may lack the topology, and then add nothing
    bool adaptive = false;
    Node channel; ///< where metadata of fields may stand too; null: nowhere
  };
  /// Gives the tree's domains as the mesh's pieces, in the order of state/domain_id if all have
  /// one: a tree with coordsets or topologies is one domain, any other has one a child, or none.
  /// Cells and coordinates are given anew where they, or their places, are others than before.
  /// Throws Error; the mesh then is not to be used before another update.
  void update(const Node& data, const Options& options);

  /// What of the last tree is not given to the mesh, a line each.
  const std::vector<std::string>& left_out() const { return left_out_; }

private:
  void read_and_give(const Node& data, const Options& options);
  void give(std::int32_t piece, const Domain& now, const Domain* before);
  void give_fields(std::int32_t piece, const Domain& now);
  void give_nothing(bool adaptive);
  void remove_fields();

  insitu_mesh mesh_;
  std::vector<Domain> domains_; ///< as given
  std::vector<Domain> earlier_; ///< arrays of theirs may still be given
  bool is_given_ = false;       ///< domains_ are given, all of them
  bool is_refused_ = false;
  std::int32_t pieces_ = 0;     ///< of the mesh, at most
  std::set<std::string> fields_;
  std::vector<std::string> left_out_;
  insitu_amr lattice_ = insitu_amr_default();
  std::vector<std::int32_t> ratios_;
};

/// The names of topologies of a tree's domains beside those that are read of them without a name
/// given: other_topologies() of any domain.
std::vector<std::string> other_topologies_of(const Node& data);

/// Takes out what some domain with cells lacks, or has in another shape: a field is on all of the
/// mesh. Says which.
void keep_common_fields(std::vector<Domain>& domains, std::vector<std::string>& left_out);

/// Makes domains of uniform blocks and levels patches of a lattice, which has room for the ratios
/// in `ratios`. Fields on vertices are left out, layers of duplicates around a patch taken off.
void make_patches(std::vector<Domain>& domains, insitu_amr& lattice,
                  std::vector<std::int32_t>& ratios, std::vector<std::string>& left_out);

} // namespace insitu::blueprint
