// SPDX-License-Identifier: Apache-2.0
#include "step/note_contacts.h"

namespace spheretree::runtime {

void noteContacts(const RowSet& set, const Configuration& before, const StepParts& parts) {
  const CompiledScene& scene = parts.scene;
  StepMemory& memory = parts.memory;
  const QpAnswer& answer = memory.answer;
  memory.contact_count = 0;
  const Eigen::Matrix3d rotation = memory.graphic.orientation.toRotationMatrix();
  Eigen::Matrix3d back;  // from now to before
  if (parts.rubsOrGives()) back = (before.orientation * memory.graphic.orientation.conjugate()).toRotationMatrix();
  for (std::size_t k = 0; k < answer.active_count; ++k) {
    const std::uint32_t row = answer.active[k];
    const RowName& name = memory.active_names[k];
    const double weight = static_cast<double>(set.weight[row]);
    Contact& contact = memory.contacts[memory.contact_count++];
    contact = {};
    contact.object = name.object;
    contact.on_wall = name.of_wall;
    contact.on_skin = memory.feelsSkin(name.object) && !name.of_wall;
    for (std::size_t axis = 0; axis < 3; ++axis)
      contact.normal[static_cast<Eigen::Index>(axis)] = static_cast<double>(set.rows.a[axis][row]) / weight;
    contact.force = scene.pull.translation * answer.multiplier[k] * weight;
    const std::uint32_t tool_slot = name.pair >> 16, slot = name.pair & 0xffff;
    const CompiledShape& shape = scene.shapeOf(name.object);
    // A coarse set has inner nodes, which represent no particular leaf.
    const std::uint32_t tool_item = set.along ? scene.hulls.tree.item[tool_slot % scene.hulls.ways_apart] : scene.tool.item[tool_slot],
                        item = contact.on_wall   ? 0
                               : contact.on_skin ? shape.skin.tree.item[slot]
                                                 : shape.leaves.item[slot];
    if (tool_item == kNoItem || item == kNoItem) {
      --memory.contact_count;
      continue;
    }
    contact.tool_leaf = set.along ? tool_item : scene.tool_nodes[tool_item];
    if (!contact.on_wall) contact.element = contact.on_skin ? item : shape.nodes[item];
    contact.point = memory.graphic.position + armOf(parts.scene, set, row, name, contact.normal, rotation);
    if (!parts.rubsOrGives()) continue;
    contact.friction = scene.pull.translation * memory.active_rubbing[k];
    const std::uint32_t body = memory.objects[name.object].body;
    Eigen::Vector3d from = before.position + back * (contact.point - memory.graphic.position);
    if (body > 0) {
      const MovingBody& mover = memory.bodies[body];
      from = mover.now.orientation * (mover.before.orientation.conjugate() * (from - mover.before.position)) + mover.now.position;
    }
    Eigen::Vector3d slid = contact.point - from;
    if (memory.isTissue(name.object)) slid -= memory.tissue->contacts().movedInStep(name.object, k);
    contact.slip = (slid - slid.dot(contact.normal) * contact.normal) / scene.step_time;
  }
}

}  // namespace spheretree::runtime
