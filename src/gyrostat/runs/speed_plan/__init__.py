"""Plans of wheel speeds that avoid zero and bands of speeds in science windows."""
