#pragma once

#include "cells/kernels/ray_cell.h"

namespace insitu::render {

using cells::Crossing;
using cells::face_crossings;
using cells::most_crossings;
using cells::RaySpace;

} // namespace insitu::render
