#pragma once

#include <isofront/core/Powers.h>

#include <algorithm>

namespace isofront::surface {

/// How much coarser than asked for a surface must be to stay below its ceilings: the least of a
/// row of factors at which it fits, found by trying.
class BudgetControl {
public:
    /// By which all errors that are asked for are to be multiplied.
    [[nodiscard]] double factor() const { return core::twoToEighths(_step); }
    [[nodiscard]] bool isActive() const { return _step > 0; }
    /// True if no factor fits that is left to try.
    [[nodiscard]] bool isAtItsEnd() const { return _step == kMostSteps; }

    /// What the present factor leads to has been seen not to fit.
    void coarsen(int steps = 1)
    {
        _tooFine = std::max(_tooFine, _step);
        _step = std::min(_step + steps, kMostSteps);
    }
    /// It will hardly fit; nothing is proved.
    void coarsenOnSuspicion(int steps) { _step = std::min(_step + steps, kMostSteps); }
    /// True if the next finer one may fit.
    [[nodiscard]] bool mayRefine() const { return _step > 0 && _step - 1 > _tooFine; }
    void refine() { --_step; }
    /// The view has changed: what didn't fit may fit now.
    void forget() { _tooFine = -1; }

private:
    /// A factor of 2^40, beyond which there is nothing left to save.
    static constexpr int kMostSteps = 320;

    int _step = 0;
    int _tooFine = -1; ///< the coarsest step that is known not to fit
};

} // namespace isofront::surface
