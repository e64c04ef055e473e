; SPDX-License-Identifier: Apache-2.0
;
; What edge_dda.sv leaves to arithmetic, over the integers: each question asks for a counterexample. x in
; pixels at a scanline's centre, S sub-pixels to a pixel, P = 2 S dy x: one scanline down it is P + 2 S dx.
; The host divides P + S dy - 1 = 2 S m + r, and takes m and dx apart by dy.

(declare-const S Int) (declare-const dy Int) (declare-const dx Int) (declare-const P Int)
(declare-const m Int) (declare-const r Int) (declare-const q Int) (declare-const over Int)
(declare-const step Int) (declare-const increment Int) (declare-const carry Int)

(push) ; One scanline down, m - q dy changes by increment - carry dy.
(assert (= over (- m (* q dy))))
(assert (= dx (+ (* step dy) increment)))
(assert (not (= (+ over (- increment (* carry dy)))
                (- (+ m dx) (* (+ q step carry) dy)))))
(check-sat)
(pop)

(push) ; One scanline down, r stays: P + S dy - 1 = 2 S m + r.
(assert (= (+ P (* S dy) (- 1)) (+ (* 2 S m) r)))
(assert (not (= (+ P (* 2 S dx) (* S dy) (- 1)) (+ (* 2 S (+ m dx)) r))))
(check-sat)
(pop)

(push) ; 0 <= over < dy, S times.
(assert (and (>= over 0) (< over dy) (>= S 1)))
(assert (not (and (>= (* S over) 0) (<= (* S over) (- (* S dy) S)))))
(check-sat)
(pop)

(push) ; Hence q is ceil(x - 1/2): -S dy < P - 2 S dy q <= S dy. w and v are S over and S dy, as just bounded.
(declare-const w Int) (declare-const v Int)
(assert (and (>= r 0) (< r (* 2 S)) (>= S 1)))
(assert (= w (* S over))) (assert (= v (* S dy)))
(assert (and (>= w 0) (<= w (- v S))))
(assert (= (+ P v (- 1)) (+ (* 2 w) (* 2 S q dy) r)))
(assert (not (and (< (- v) (- P (* 2 S q dy))) (<= (- P (* 2 S q dy)) v))))
(check-sat)
(pop)
