#pragma once

#include <algorithm>
#include <limits>
#include <optional>

namespace isofront::surface {

/// Looks for the least coarse of a row of settings at which a mesh has no more triangles than it
/// may, by few trials: step 0 is as fine as was asked for, and each further step makes about the
/// same factor less triangles.
class CeilingSearch {
public:
    /// @param most    triangles
    /// @param factor  by which a step lowers their number, about; in (0, 1)
    /// @param last    the coarsest step
    CeilingSearch(double most, double factor, int last) : _most(most), _factor(factor), _last(last)
    {
    }

    /// The step to try next; nothing when the search is over.
    [[nodiscard]] std::optional<int> next() const
    {
        if (_next > _last || _next >= _fits)
            return std::nullopt;
        return _next;
    }
    /// What came of it: how many triangles there are, or would be, about.
    /// @param fits  whether they are no more than there may be
    void tell(double triangles, bool fits)
    {
        const double ratio = std::max(triangles, 1.0) / _most;
        int jump = 0; // as far as one can tell, and rather too little
        for (double off = std::max(ratio, 1 / ratio) * _factor; off >= 1 && jump < _last; ++jump)
            off *= _factor;
        (fits ? _fits : _tooFine) = _next;
        if (_fits <= _last) {
            // between the two, and well away from where it has been, should belief be wrong
            const int gap = _fits - _tooFine;
            const int least = std::max(1, gap / 4);
            jump = std::clamp(jump, least, std::max(least, gap - 1));
            _next = fits ? std::max(_fits - jump, _tooFine + 1) : _tooFine + jump;
        } else {
            _jump = std::max({jump, 2 * _jump, 1});
            _next = std::min(_tooFine + _jump, std::max(_last, _tooFine + 1));
        }
    }

private:
    double _most;
    double _factor;
    int _last;
    int _next = 0;
    int _jump = 0; ///< the last, while none fits
    int _tooFine = -1;
    int _fits = std::numeric_limits<int>::max();
};

} // namespace isofront::surface
