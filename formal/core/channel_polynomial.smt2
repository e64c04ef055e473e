; SPDX-License-Identifier: Apache-2.0
;
; What channel.sv leaves to arithmetic, over the integers: the polynomial that the words stand for,
;   f(m, N) = I + m R + C(m, 2) E + N D + m N F + C(N + 1, 2) G,
; its step down and its step to the right are what channel.sv adds up. Doubled, for the sake of the binomials.
; Each question asks for a counterexample; what holds in integers holds modulo 2**word_width.

(declare-const I Int) (declare-const R Int) (declare-const D Int)
(declare-const E Int) (declare-const F Int) (declare-const G Int)
(declare-const m Int) (declare-const N Int) (declare-const c Int)

(define-fun twice_f ((m Int) (N Int)) Int
  (+ (* 2 I) (* 2 m R) (* m (- m 1) E) (* 2 N D) (* 2 m N F) (* (+ N 1) N G)))
(define-fun row ((m Int) (N Int)) Int (+ R (* m E) (* N F)))
(define-fun col ((m Int) (N Int)) Int (+ D (* m F) (* N G)))

(push) ; The first scanline.
(assert (not (and (= (twice_f 0 0) (* 2 I)) (= (row 0 0) R) (= (col 0 0) D))))
(check-sat)
(pop)

(push) ; One scanline down, with a carry or without.
(assert (or (= c 0) (= c 1)))
(assert (not (= (twice_f (+ m 1) (+ N c))
                (+ (twice_f m N) (* 2 (row m N)) (* 2 c (col (+ m 1) (+ N c)))))))
(check-sat)
(pop)

(push) ; So do its steps go.
(assert (not (and (= (row (+ m 1) (+ N c)) (+ (row m N) E (* c F)))
                  (= (col (+ m 1) (+ N c)) (+ (col m N) F (* c G))))))
(check-sat)
(pop)

(push) ; One pixel to the right.
(assert (not (and (= (twice_f m (+ N 1)) (+ (twice_f m N) (* 2 (col m (+ N 1)))))
                  (= (col m (+ N 1)) (+ (col m N) G)))))
(check-sat)
(pop)
