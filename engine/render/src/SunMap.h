#pragma once

#include "SunBox.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Image.h>
#include <isofront/hierarchy/Domain.h>

#include <optional>
#include <utility>

namespace isofront::render {

/// The sun's view of what casts shadows, as the present picture has it. While a transition runs,
/// the one of the former picture is kept beside it: so shadows fade with what casts them.
class SunMap {
public:
    /// @param texels  along a side
    static core::Result<SunMap> create(gpu::Device& device, int texels);

    /// The next frame begins a transition.
    void beginTransition() { _begins = true; }
    /// Decides which surroundings the maps of a frame show. Takes memory for a second map when the
    /// first transition is seen.
    /// @param wanted    what the frame's view asks for
    /// @param interval  after how many frames the present map is drawn anew, at the latest
    /// @param weight    of the present picture
    /// @return whether the present map must be drawn
    core::Result<bool> update(
        gpu::Device& device,
        const hierarchy::Domain& domain,
        const SunBox& wanted,
        int interval,
        float weight);
    /// The frame that was to draw the present map has been submitted.
    void setDrawn() { _age = 1; }

    [[nodiscard]] const gpu::Image& present() const { return _present; }
    /// The present one, if there is no other.
    [[nodiscard]] const gpu::Image& former() const
    {
        return _formerBox.casts ? *_former : _present;
    }
    [[nodiscard]] const SunBox& box() const { return _box; }
    /// Of the present box's size and axes; null if shadows are those of the present picture alone.
    [[nodiscard]] const SunBox* formerBox() const
    {
        return _formerBox.casts ? &_formerBox : nullptr;
    }
    [[nodiscard]] int texels() const { return static_cast<int>(_present.extent().width); }

private:
    explicit SunMap(gpu::Image present) : _present(std::move(present)) {}
    core::Result<void> keepPresent(gpu::Device& device, const SunBox& box);

    gpu::Image _present;
    std::optional<gpu::Image> _former;
    SunBox _box;       ///< what the present map shows
    SunBox _formerBox; ///< it casts nothing if the former map isn't to be seen
    int _age = 0;      ///< of the present map [frames]
    bool _begins = false;
};

} // namespace isofront::render
