#include "commands/refreshed_frames.h"

#include "report/format.h"
#include "measure.h"
#include "render/structures/structures.h"
#include "report/report.h"

namespace insitu::bench {

RefreshedFrames refresh_frames(Setup& setup, commit::CommittedMesh& mesh,
                               const render::FrameSettings& settings) {
  RefreshedFrames out;
  render::Structures structures(setup.context.memory);
  const core::Threads single(1);
  const auto seconds = [&] {
    const render::Structures::Seconds& s = structures.seconds();
    return s.vertex_cells + s.averages + s.value_ranges + s.gradients + s.macrocells + s.majorants;
  };
  double frame = 0; // of the last cycle: gradients are found while it is drawn
  const auto cycle = [&] {
    Series one;
    one.time([&] {
      structures.begin(mesh.sampler(), mesh.tree_version(), mesh.fields_version(), single);
      (void)render::render_frame(mesh.sampler(), settings, structures, single);
      structures.end();
    });
    frame = one.for_ratio(1);
    return structures.counts();
  };
  // So many queries may pay for a better tree, once: the commit after that is looked at.
  std::uint64_t tree;
  render::Structures::Counts before, after = cycle();
  double spent = seconds(), anew = spent, refreshed = 0, frame_anew = frame;
  insitu_commit_report report;
  int commits = 0;
  do {
    tree = mesh.tree_version();
    before = after;
    mesh.mesh().set_changed(INSITU_CHANGED_FIELDS);
    report = setup.commit(mesh);
    after = cycle();
    refreshed = seconds() - spent;
    spent += refreshed;
    if (mesh.tree_version() != tree) {
      anew = refreshed;
      frame_anew = frame;
    }
  } while (mesh.tree_version() != tree && ++commits < 4);
  const double frame_refreshed = frame;
  cycle(); // of nothing new
  const auto made = [](const render::Structures::Counts& c) {
    return c.vertex_cells + c.averages + c.value_ranges + c.gradients + c.macrocells +
           c.primitive_ranges;
  };
  const auto given = [](const render::Structures::Counts& c) {
    return c.averages_refreshed + c.value_ranges_refreshed + c.gradients_refreshed +
           c.macrocells_refreshed + c.majorants + c.primitive_ranges_refreshed;
  };
  const std::int64_t built = made(after) - made(before) + std::int64_t(mesh.tree_version() != tree);
  const std::int64_t kept = given(after) - given(before);
  out.text =
      format("after a commit of new values alone (%.1f us), of a sparse volume and a lit "
             "isosurface: %lld structures\n  built anew, %lld given new values in place in "
             "%.3f s (made, they took %.3f s); the frame takes %.3f s (%.3f s), "
             "and again, of nothing new, %.3f s\n",
             1e6 * report.seconds, static_cast<long long>(built), static_cast<long long>(kept),
             refreshed, anew, frame_refreshed, frame_anew, frame);
  out.json = {{"built_after_fields_commit", built},
              {"refreshed_after_fields_commit", kept},
              {"refresh_s", number(refreshed)},
              {"structures_s", number(anew)},
              {"refreshed_frame_s", number(frame_refreshed)},
              {"frame_again_s", number(frame)},
              {"first_frame_s", number(frame_anew)}};
  return out;
}

} // namespace insitu::bench
