/// What probes answered, for callers that act on it.
#include "insitu/c/probe.h"

#include "api/entry.h"
#include "api/session.h"
#include "core/caller_struct.h"
#include "scene/probes/probe_action.h"

namespace insitu::core {

INSITU_CALLER_STRUCT(insitu_probe_answers);

} // namespace insitu::core

namespace insitu::api {

using core::Error;

void Session::keep_answers(std::int32_t keep) {
  meet("keep_answers");
  processes_.world().require_same([&] {
    return std::vector<parallel::Named>{{"whether to keep answers", std::to_string(keep)}};
  });
  processes_.world().agree_after([&] {
    if (keep != 0 && keep != 1)
      throw Error(INSITU_ERROR_ARGUMENT, "keep: " + std::to_string(keep) + ", 0 or 1 expected");
  });
  keeps_answers_ = keep == 1;
  if (runner_)
    runner_->keep_answers(keeps_answers_);
}

void Session::answers(std::int32_t probe, insitu_probe_answers* answers, std::int32_t* count) {
  *count = runner_ ? std::int32_t(runner_->probes().size()) : 0;
  if (!answers)
    return;
  if (probe < 0 || probe >= *count)
    throw Error(INSITU_ERROR_ARGUMENT, "probe: " + std::to_string(probe) + ", the scene has " +
                                           std::to_string(*count) + " probes, numbered from 0");
  const scene::ProbeAction& action = *runner_->probes()[std::size_t(probe)];
  insitu_probe_answers out = insitu_probe_answers_default();
  out.name = action.name().c_str();
  if (const std::optional<scene::KeptAnswers>& kept = action.answers()) {
    static_assert(sizeof(math::Vec3d) == 3 * sizeof(double));
    out.answered = 1;
    out.cycle = kept->cycle;
    out.time = kept->time;
    out.column_count = std::int32_t(kept->columns.size());
    out.point_count = std::int64_t(kept->points.size());
    out.column_names = kept->column_names.data();
    out.points = reinterpret_cast<const double*>(kept->points.data());
    out.inside = kept->inside.data();
    out.values = kept->values.data();
  }
  core::to_caller(out, answers, "answers");
}

} // namespace insitu::api

extern "C" {

insitu_status insitu_session_keep_answers(insitu_session session, int32_t keep) {
  return insitu::api::with_session(session, [&](insitu::api::Session& s) { s.keep_answers(keep); });
}

insitu_status insitu_session_answers(insitu_session session, int32_t probe,
                                     insitu_probe_answers* answers, int32_t* count) {
  return insitu::api::with_session(session, [&](insitu::api::Session& s) {
    insitu::api::require(count, "count");
    s.answers(probe, answers, count);
  });
}

} // extern "C"
