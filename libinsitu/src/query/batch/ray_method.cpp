#include "query/batch/ray_method.h"

#include "query/batch/ray_batch.h"
#include "query/batch/tree_locator.h"

namespace insitu::query {

void RayMethod::with_batches(const PointQuery& query, Ask ask) const {
  BatchLocator tree(query, batch_scratch());
  RayBatch by_rays(query, rays_, batch_scratch(), tree, batch_answers());
  BatchesBy batches(by_rays);
  ask(batches);
  counts_.kept += by_rays.kept;
  counts_.by_neighbour += by_rays.by_neighbour;
  counts_.by_tree += by_rays.by_tree;
}

} // namespace insitu::query
