//! reconstruct(): the stages in order.
