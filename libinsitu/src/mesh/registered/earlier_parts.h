#pragma once

#include "mesh/registered/earlier_step.h"

/// Copies of earlier steps that are put together from those of parts of a mesh.
namespace insitu::mesh {

/// A mesh without its halo.
MeshView own_part(const MeshView& mesh);

/// Adds to a step that of the pieces behind its own; a field that is missing there makes it unfit.
void append(EarlierStep& step, const EarlierStep& behind);
/// Makes room for all items of the mesh, which is not adaptive; those that there are stay.
void resize(EarlierStep& step, const MeshView& mesh);
/// Whether both have the same fields, and of each as many steps.
bool have_same_fields(const EarlierStep& a, const EarlierStep& b);

} // namespace insitu::mesh
