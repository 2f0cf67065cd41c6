#include "renderer/light_tree_layout.h"

#include <algorithm>
#include <utility>

namespace equilux {
namespace {

// A walk from the root, with the class of the largest node that each node's representative stands for.
class DraftWalk {
 public:
  explicit DraftWalk(const TreeDraft& draft) : draft_(draft) {}

  std::size_t own_class(std::uint32_t node) const { return find_size_class(draft_.counts[node]); }
  std::size_t child_class(std::uint32_t parent, std::size_t parent_class, std::uint32_t child) const {
    const bool same = draft_.nodes[child].representative == draft_.nodes[parent].representative;
    return same ? parent_class : own_class(child);
  }

 protected:
  const TreeDraft& draft_;
};

class Measurer : public DraftWalk {
 public:
  using DraftWalk::DraftWalk;

  void measure(std::uint32_t index, std::size_t vpl_class, DraftSizes& sizes) const {
    const LightNode& node = draft_.nodes[index];
    if (node.leaf_count > 0) {
      sizes.vpls[vpl_class] += node.leaf_count;
      return;
    }
    ++sizes.pairs[own_class(index)];
    for (std::uint32_t child : {index + 1, node.next})
      measure(child, child_class(index, vpl_class, child), sizes);
  }
};

class Placer : public DraftWalk {
 public:
  Placer(const TreeDraft& draft, const LargeArray<Vpl>& sorted, DraftSizes next, LightTree& tree)
      : DraftWalk(draft), sorted_(sorted), next_(next), tree_(tree) {}

  std::uint32_t place(std::uint32_t index, std::uint32_t target, std::size_t vpl_class) {
    LightNode node = draft_.nodes[index];
    if (node.leaf_count > 0) {
      const std::uint32_t first = next_.vpls[vpl_class];
      next_.vpls[vpl_class] += node.leaf_count;
      std::copy_n(&sorted_[node.next], node.leaf_count, &tree_.vpls.vpls[first]);
      node.representative += first - node.next;
      node.next = first;
    } else {
      std::uint32_t first = index + 1, second = node.next;
      if (node.representative == draft_.nodes[second].representative) std::swap(first, second);
      const std::uint32_t pair = next_.pairs[own_class(index)];
      next_.pairs[own_class(index)] += 2;
      node.representative = place(first, pair, vpl_class);
      place(second, pair + 1, own_class(second));
      node.next = pair;
    }
    tree_.nodes[target] = node;
    if (!draft_.gloss.empty()) tree_.gloss[target] = draft_.gloss[index];
    return node.representative;
  }

 private:
  const LargeArray<Vpl>& sorted_;
  DraftSizes next_;
  LightTree& tree_;
};

}  // namespace

std::size_t find_size_class(std::uint32_t count) {
  std::size_t found = 0;
  for (std::uint32_t least = 4096; least > 1 && count < least; least /= 8) ++found;
  return found;
}

DraftSizes measure_draft(const TreeDraft& draft, std::size_t root_class) {
  DraftSizes sizes;
  Measurer(draft).measure(0, root_class, sizes);
  return sizes;
}

std::uint32_t place_draft(const TreeDraft& draft, const LargeArray<Vpl>& sorted, std::uint32_t root,
                          std::size_t root_class, DraftSizes starts, LightTree& tree) {
  return Placer(draft, sorted, starts, tree).place(0, root, root_class);
}

}  // namespace equilux
